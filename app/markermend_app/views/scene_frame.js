import { css } from "./scene_colour.js";
import { GRID_MM, MAGNIFIED } from "./scene_lens.js";

// What stands around the drawing: the label, the legend, the lens, and a line where WebGL is missing.
const STYLE = `
.scene{position:absolute;inset:0;overflow:hidden;font:12px Roboto,system-ui,sans-serif;
  background:var(--view);color:var(--ink2);user-select:none}
.draw{position:absolute;inset:0;touch-action:none;cursor:grab}
.draw:active{cursor:grabbing}
.draw>*{position:absolute!important;inset:0;width:100%!important;height:100%!important}
.label{position:absolute;left:0;top:0;font-weight:700;color:var(--ink);white-space:nowrap;
  pointer-events:none;text-shadow:0 0 2px var(--view),0 0 2px var(--view),0 0 4px var(--view)}
.legend{position:absolute;left:12px;bottom:10px;display:flex;flex-direction:column;gap:5px;
  pointer-events:none}
.legend div{display:flex;align-items:center;gap:7px}
.lens{position:absolute;right:10px;bottom:10px;width:min(150px,34%);aspect-ratio:1;
  border:1px solid var(--line2);border-radius:8px;overflow:hidden;background:var(--panel);
  pointer-events:none}
.lens canvas{width:100%;height:100%;display:block}
.lens em{position:absolute;font-style:normal;font-size:11px;color:var(--ink3)}
.note{position:absolute;left:12px;top:10px;color:var(--ink2)}
[hidden]{display:none!important}`;

const MARKUP = `
<div class="draw" role="img"></div>
<div class="label" hidden></div>
<div class="legend"></div>
<div class="lens" hidden><canvas aria-hidden="true"></canvas>
<em style="left:7px;top:4px">${MAGNIFIED} ×</em><em style="right:7px;bottom:5px">grid ${GRID_MM} mm</em></div>
<div class="note" role="status" hidden></div>`;

const symbol = (inside) => `<svg width="12" height="12" aria-hidden="true">${inside}</svg>`;

export class Surround {
  constructor(el) {
    this.root = document.createElement("div");
    this.root.className = "scene";
    this.root.innerHTML = `<style>${STYLE}</style>${MARKUP}`;
    el.append(this.root);
    const find = (selector) => this.root.querySelector(selector);
    this.draw = find(".draw");
    this.label = find(".label");
    this.legend = find(".legend");
    this.lens = find(".lens");
    this.note = find(".note");
  }

  setColours(colours) {
    for (const [name, value] of Object.entries(colours)) {
      this.root.style.setProperty(`--${name}`, value);
    }
  }

  say(sentence) {
    this.note.hidden = !sentence;
    this.note.textContent = sentence;
  }

  describe(label, frame) {
    this.draw.setAttribute("aria-label",
      label ? `3D view, frame ${frame}, marker ${label} selected` : `3D view, frame ${frame}`);
  }

  setLegend(picture, colours) {
    const state = [picture.selected >= 0, picture.hasRaw && css(picture.colour),
      picture.neighbours.length > 0, css(colours.accent), css(colours.ink)].join();
    if (state === this.legendState) return;
    this.legendState = state;
    const rows = [];
    if (picture.selected >= 0) {
      const name = picture.hasRaw || picture.neighbours.length ? "Repaired" : "Selected";
      rows.push(["<circle cx='6' cy='6' r='4.5' fill='var(--accent)'/>", name]);
    }
    if (picture.hasRaw) {
      const ring = `<circle cx='6' cy='6' r='4' fill='none' stroke-width='2' stroke='${css(picture.colour)}'/>`;
      rows.push([ring, "Raw"]);
    }
    if (picture.neighbours.length) {
      rows.push(["<circle cx='6' cy='6' r='2' fill='var(--marker)'/>" +
        "<circle cx='6' cy='6' r='4.5' fill='none' stroke='var(--ink)'/>", "Neighbours"]);
    }
    this.legend.innerHTML = rows.map(([drawn, word]) => `<div>${symbol(drawn)}${word}</div>`).join("");
  }

  placeLabel(picture, camera, label) {
    const i = picture.selected;
    const shown = i >= 0 && picture.seen[i] === 1;
    this.label.hidden = !shown;
    if (!shown) return;
    if (this.label.textContent !== label) this.label.textContent = label;
    const x = picture.screen[3 * i], y = picture.screen[3 * i + 1];
    const side = x > 0.62 * camera.width ? "calc(-100% - 13px)" : "13px";
    this.label.style.transform = `translate(${x}px,${y}px) translate(${side},-50%)`;
  }
}
