// A list of any length: only the rows that can be seen exist. Rows are HTML made by Python.
export function render({ model, el }) {
  const list = document.createElement("div");
  list.className = "root rows";
  list.setAttribute("role", "listbox");
  list.setAttribute("aria-label", "Findings");
  list.tabIndex = 0;
  const spacer = document.createElement("div");
  list.append(spacer);
  el.append(list);
  const shown = new Map();

  const rowHeight = () => parseFloat(getComputedStyle(list).getPropertyValue("--row")) || 30;

  const draw = () => {
    const height = rowHeight(), rows = model.rows;
    spacer.style.height = `${rows.length * height}px`;
    const first = Math.max(0, Math.floor(list.scrollTop / height) - 5);
    const last = Math.min(rows.length, Math.ceil((list.scrollTop + list.clientHeight) / height) + 5);
    const wanted = new Map();
    for (let i = first; i < last; i++) wanted.set(rows[i].id, i);
    for (const [id, row] of shown) {
      if (!wanted.has(id)) { row.remove(); shown.delete(id); }
    }
    for (const [id, i] of wanted) {
      let row = shown.get(id);
      if (!row) {
        row = document.createElement("div");
        shown.set(id, row);
        list.append(row);
      }
      const selected = id === model.selected;
      const markup = rows[i].html;
      if (row.markup !== markup) { row.innerHTML = markup; row.markup = markup; }
      row.className = rows[i].divider ? "divider" : `row ${rows[i].settled ? "settled" : ""}`;
      row.style.top = `${i * height}px`;
      row.dataset.id = id;
      if (!rows[i].divider) {
        row.setAttribute("role", "option");
        row.setAttribute("aria-selected", selected);
        row.setAttribute("aria-posinset", i + 1);
        row.setAttribute("aria-setsize", rows.length);
      }
    }
  };

  const reveal = () => {
    const height = rowHeight();
    const at = model.rows.findIndex((row) => row.id === model.selected);
    if (at < 0) return;
    const top = at * height;
    if (top < list.scrollTop) list.scrollTop = top;
    if (top + height > list.scrollTop + list.clientHeight) {
      list.scrollTop = top + height - list.clientHeight;
    }
  };

  list.addEventListener("click", (event) => {
    const row = event.target.closest(".row");
    if (row) model.send_msg({ do: "select", arg: row.dataset.id, fields: {} });
  });
  list.addEventListener("scroll", draw, { passive: true });
  const observer = new ResizeObserver(draw);
  observer.observe(list);
  model.on("rows", () => { reveal(); draw(); });
  model.on("selected", () => { reveal(); draw(); });
  model.on("remove", () => observer.disconnect());
  reveal();
  draw();
}
