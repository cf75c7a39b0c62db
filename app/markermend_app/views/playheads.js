// Moves the playheads (Bokeh spans of that name) with the 3D view's frames, and seeks where a figure
// with the tag "seeks" is tapped.
// A figure that paints itself for every frame is far too slow, so that each span is drawn by a line
// of HTML over its figure; the span itself stays hidden and keeps the time, without telling Python.
let entries = [];

// Bokeh asks for the style of an element for every line, fill and word that it paints, in case a
// style sheet says otherwise (`--bk-…`), and for the size of letters by which relative ones are
// measured; each time the browser has to bring the whole page's style up to date. Ours say nothing
// of the kind, and all letters in figures are so many pixels high.
function withoutStyleSheets(plot) {
  Object.defineProperty(plot, "base_font_size", { value: plot.base_font_size });
  for (const visual of plot.visuals) {
    let kind = visual;
    while (kind && !Object.hasOwn(kind, "_get_css_value")) kind = Object.getPrototypeOf(kind);
    if (kind) kind._get_css_value = () => "";
  }
}

function attach(view) {
  const { canvas_view: canvas, model: plot } = view.plot_view;
  withoutStyleSheets(view.plot_view);
  const line = document.createElement("div");
  line.className = "playhead";
  Object.assign(line.style, { position: "absolute", left: 0, pointerEvents: "none" });
  canvas.overlays_el.append(line);
  const entry = { view, cursor: view.model, line };
  entry.cursor.setv({ visible: false }, { sync: false });
  entry.cursor.change.connect(() => place(entry));
  plot.x_range.change.connect(() => place(entry));
  new ResizeObserver(() => place(entry)).observe(canvas.el);
  if (plot.tags.includes("seeks")) {
    plot.on_event("tap", ({ x }) => {
      window.dispatchEvent(new CustomEvent("markermend:seek", { detail: { time: x } }));
    });
  }
  place(entry);
  return entry;
}

function place({ cursor, line, view }) {
  const { left, right, top, height } = view.plot_view.frame.bbox;
  const x = view.coordinates.x_scale.compute(cursor.location);
  const width = cursor.line_width?.value ?? cursor.line_width;
  Object.assign(line.style, {
    display: x >= left && x <= right ? "block" : "none",
    top: `${top}px`,
    height: `${height}px`,
    width: `${width}px`,
    background: cursor.line_color?.value ?? cursor.line_color,
    transform: `translateX(${x - width / 2}px)`,
  });
}

// Figures come onto the page one after the other.
function find() {
  const known = new Set(entries.map((entry) => entry.view));
  for (const view of Bokeh.index.query((view) => view.model.name === "playhead")) {
    if (!known.has(view) && view.plot_view?.canvas_view) entries.push(attach(view));
  }
}

export function render({ model, el }) {
  el.style.display = "none";
  const follow = ({ detail }) => {
    if (!entries.length || entries.some((entry) => !entry.line.isConnected)) {
      entries = entries.filter((entry) => entry.line.isConnected);
      find();
    }
    for (const entry of entries) {
      entry.cursor.setv({ location: detail.time }, { silent: true });
      place(entry);
    }
  };
  window.addEventListener("markermend:frame", follow);
  const document = model.model?.document ?? Bokeh.documents[0];
  document?.idle.connect(find);
  if (document?.is_idle) find();
  model.on("remove", () => {
    window.removeEventListener("markermend:frame", follow);
    entries = [];
  });
}
