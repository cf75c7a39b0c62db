// What belongs to the whole document and not to a part of it: theme, title, the clock in the
// transport, which moves with every frame without asking Python.
export function render({ model, el }) {
  el.style.display = "none";
  const theme = () => { document.documentElement.dataset.theme = model.theme; };
  const title = () => { document.title = model.title; };
  model.on("theme", theme);
  model.on("title", title);
  theme();
  title();

  const clock = ({ detail }) => {
    const host = document.querySelector(".cell-transport");
    const root = host?.querySelector("[data-root-id], .bk-panel-models-esm-ReactiveESM, div");
    const find = (node, selector) => {
      if (!node) return null;
      const found = node.querySelector?.(selector);
      if (found) return found;
      for (const child of node.querySelectorAll?.("*") ?? []) {
        if (child.shadowRoot) {
          const deep = find(child.shadowRoot, selector);
          if (deep) return deep;
        }
      }
      return null;
    };
    const time = find(host ?? root, "[data-time]");
    if (!time) return;
    time.textContent = `${detail.time.toFixed(2)} s`;
    const part = time.closest(".transport");
    part.querySelector("[data-frame]").textContent = `frame ${detail.frame + model.first_frame}`;
    const slider = part.querySelector("input[type=range]");
    if (part.getRootNode().activeElement !== slider || detail.playing) slider.value = detail.frame;
  };
  window.addEventListener("markermend:frame", clock);
  const slide = (event) => {
    const target = event.composedPath()[0];
    if (target.matches?.(".transport input[type=range]")) {
      window.dispatchEvent(
        new CustomEvent("markermend:seek", { detail: { frame: Number(target.value) } }),
      );
    }
  };
  window.addEventListener("input", slide, true);
  model.on("remove", () => {
    window.removeEventListener("markermend:frame", clock);
    window.removeEventListener("input", slide, true);
  });
  if (matchMedia("(prefers-color-scheme: dark)").matches) {
    model.send_msg({ do: "prefer_dark", arg: null, fields: {} });
  }
}
