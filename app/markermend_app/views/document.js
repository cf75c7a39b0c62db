// What belongs to the whole document and not to a part of it: theme, title, and the clock and
// scrubber of the transport, which follow every frame without asking Python.
function findDeep(node, selector) {
  const found = node.querySelector(selector);
  if (found) return found;
  for (const child of node.querySelectorAll("*")) {
    const deep = child.shadowRoot && findDeep(child.shadowRoot, selector);
    if (deep) return deep;
  }
  return null;
}

export function render({ model, el }) {
  el.style.display = "none";
  const theme = () => { document.documentElement.dataset.theme = model.theme; };
  const title = () => { document.title = model.title; };
  model.on("theme", theme);
  model.on("title", title);
  theme();
  title();

  let transport = null;
  const clock = ({ detail }) => {
    if (!transport?.isConnected) {
      transport = findDeep(document.querySelector(".cell-transport"), ".transport");
    }
    const time = transport?.querySelector("[data-time]");
    if (!time) return;
    time.textContent = `${detail.time.toFixed(2)} s`;
    transport.querySelector("[data-frame]").textContent = `frame ${detail.frame + model.first_frame}`;
    transport.querySelector("input[type=range]").value = detail.frame;
  };
  const slide = (event) => {
    const slider = event.composedPath()[0];
    if (!slider.matches?.(".transport input[type=range]")) return;
    const detail = { frame: Number(slider.value) };
    window.dispatchEvent(new CustomEvent("markermend:seek", { detail }));
  };
  window.addEventListener("markermend:frame", clock);
  window.addEventListener("input", slide, true);
  model.on("remove", () => {
    window.removeEventListener("markermend:frame", clock);
    window.removeEventListener("input", slide, true);
  });
  if (matchMedia("(prefers-color-scheme: dark)").matches) {
    model.send_msg({ do: "prefer_dark", arg: null, fields: {} });
  }
}
