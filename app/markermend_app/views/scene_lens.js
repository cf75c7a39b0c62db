import { css } from "./scene_colour.js";

// The selected marker magnified, since an artefact is one percent of a body.
export const MAGNIFIED = 8;
export const GRID_MM = 20;

export class Lens {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
  }

  // Where to look: at the marker, else at its raw place, else nowhere.
  static aim({ seen, selected, xyz, ghost }) {
    return seen[selected] ? xyz.subarray(3 * selected, 3 * selected + 3) : ghost;
  }

  paint(picture, camera, colours, ratio) {
    const { canvas, pen } = this;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width) return;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);

    const { selected } = picture;
    const at = Lens.aim(picture);
    const centre = [0, 0, 0];
    camera.project(...at, centre);
    const perMm = MAGNIFIED / camera.millimetres(centre[2]);
    this.paintGrid(width, height, GRID_MM * perMm, colours);
    const place = (x, y, z) => {
      const out = [0, 0, 0];
      camera.project(x, y, z, out);
      return [width / 2 + (out[0] - centre[0]) * MAGNIFIED,
        height / 2 + (out[1] - centre[1]) * MAGNIFIED];
    };
    const kind = css(picture.colour ?? colours.ink);
    this.paintPath(picture.rawTrail, place, kind, 1.2);
    this.paintPath(picture.trail, place, css(colours.accent), 2.5);
    if (picture.seen[selected]) this.paintDot(place(...at), 5, css(colours.accent), null);
    if (picture.ghost) this.paintDot(place(...picture.ghost), 5, null, kind);
  }

  paintGrid(width, height, step, colours) {
    const { pen } = this;
    if (step < 4) return;
    pen.strokeStyle = css(colours.line);
    pen.lineWidth = 1;
    pen.beginPath();
    for (let x = (width / 2) % step; x < width; x += step) {
      pen.moveTo(x, 0);
      pen.lineTo(x, height);
    }
    for (let y = (height / 2) % step; y < height; y += step) {
      pen.moveTo(0, y);
      pen.lineTo(width, y);
    }
    pen.stroke();
  }

  paintPath(path, place, colour, lineWidth) {
    const { pen } = this;
    Object.assign(pen, { strokeStyle: colour, lineWidth, lineJoin: "round" });
    pen.beginPath();
    let down = false;
    for (let k = 0; k < path.length; k += 3) {
      if (path[k] !== path[k]) {
        down = false;
        continue;
      }
      const [x, y] = place(path[k], path[k + 1], path[k + 2]);
      if (down) pen.lineTo(x, y);
      else pen.moveTo(x, y);
      down = true;
    }
    pen.stroke();
  }

  paintDot([x, y], radius, fill, stroke) {
    const { pen } = this;
    pen.beginPath();
    pen.arc(x, y, radius, 0, 7);
    if (fill) {
      pen.fillStyle = fill;
      pen.fill();
    }
    if (stroke) {
      Object.assign(pen, { strokeStyle: stroke, lineWidth: 2 });
      pen.stroke();
    }
  }
}
