// The code of a CustomJS, see scene.py: moves the `cursors` (Bokeh spans) with the 3D view's frames.
// A figure that paints itself for every frame is far too slow, so that each span is drawn by a line
// of HTML over its figure; the span itself stays hidden and keeps the time, without telling Python.
const lines = cursors.map((cursor) => {
  const line = document.createElement("div");
  line.className = "playhead";
  Object.assign(line.style, { position: "absolute", left: 0, pointerEvents: "none" });
  return { cursor, line, view: null };
});

function attach(entry) {
  const { cursor, line } = entry;
  if (entry.view && line.isConnected) return true;
  entry.view = Bokeh.index.find_one(cursor);
  if (!entry.view) return false; // its figure is not on the page yet
  const { canvas_view: canvas, model: plot } = entry.view.plot_view;
  canvas.overlays_el.append(line);
  cursor.setv({ visible: false }, { sync: false });
  cursor.change.connect(() => place(entry));
  plot.x_range.change.connect(() => place(entry));
  new ResizeObserver(() => place(entry)).observe(canvas.el);
  return true;
}

function place(entry) {
  if (!attach(entry)) return;
  const { cursor, line, view } = entry;
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

lines.forEach(place);
window.addEventListener("markermend:frame", ({ detail }) => {
  for (const entry of lines) {
    entry.cursor.setv({ location: detail.time }, { silent: true });
    place(entry);
  }
});
