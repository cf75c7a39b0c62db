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

const CHUNK = 3 * 2 ** 18;

function base64(bytes) {
  let text = "";
  for (let i = 0; i < bytes.length; i += 8192) {
    text += String.fromCharCode(...bytes.subarray(i, i + 8192));
  }
  return btoa(text);
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

  // The field is entered in the browser: what is typed next must not reach the shortcuts.
  const filter = () => findDeep(document, ".filter input")?.focus();

  // Dragging over a lane pans it, or sweeps out a span to be added.
  const adding = () => {
    for (const name of ["lane-x", "lane-y", "lane-z"]) {
      const tools = Bokeh.documents[0]?.get_model_by_name(name)?.toolbar.tools ?? [];
      for (const tool of tools) {
        if (tool.type === "PanTool") tool.active = !model.adding;
        if (tool.name === "sweep") tool.active = model.adding;
      }
    }
  };
  model.on("adding", adding);

  const over = (event) => {
    if ([...(event.dataTransfer?.types ?? [])].includes("Files")) event.preventDefault();
  };
  const drop = async (event) => {
    const file = event.dataTransfer?.files[0];
    if (!file) return;
    event.preventDefault();
    if (file.size > model.most_upload) {
      model.send_msg({ file: file.name, first: true, too_large: file.size });
      return;
    }
    const bytes = new Uint8Array(await file.arrayBuffer());
    for (let at = 0; at === 0 || at < bytes.length; at += CHUNK) {
      const last = at + CHUNK >= bytes.length;
      model.send_msg({ file: file.name, first: at === 0, last, data: base64(bytes.subarray(at, at + CHUNK)) });
    }
  };

  const listeners = [
    ["markermend:frame", clock], ["input", slide], ["markermend:filter", filter],
    ["dragover", over], ["drop", drop],
  ];
  for (const [type, listener] of listeners) window.addEventListener(type, listener, true);
  model.on("remove", () => {
    for (const [type, listener] of listeners) window.removeEventListener(type, listener, true);
  });
  if (matchMedia("(prefers-color-scheme: dark)").matches) {
    model.send_msg({ do: "prefer_dark", arg: null, fields: {} });
  }
}
