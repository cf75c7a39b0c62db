import { drawnUnlessPressed } from "./redraw.js";

// A list of any length: only the rows that can be seen exist. Rows are HTML made by Python, which
// sends the order and those rows that are new or have changed.
export function render({ model, el }) {
  const list = document.createElement("div");
  list.className = "root rows";
  list.setAttribute("role", "listbox");
  list.setAttribute("aria-label", "Findings");
  list.tabIndex = 0;
  const spacer = document.createElement("div");
  spacer.setAttribute("role", "presentation");
  list.append(spacer);
  el.append(list);
  const shown = new Map(), rows = new Map();
  let order = [];

  // Asking for a size lays the page out anew, which is dear while other parts are being changed.
  let height = 30, view = 0, top = 0;
  const measure = () => {
    height = parseFloat(getComputedStyle(list).getPropertyValue("--row")) || 30;
    view = list.clientHeight;
    top = list.scrollTop;
  };
  const scrollTo = (wanted) => { list.scrollTop = top = Math.max(0, wanted); };

  // What is found late comes in above and below the pointer; the row that rests under it stays there.
  let pointer = null;
  const underPointer = () => (pointer === null ? null : order[Math.floor((pointer + top) / height)]);
  const keepUnderPointer = (id, at) => {
    const now = order.indexOf(id);
    if (now >= 0 && now !== at) scrollTo(top + (now - at) * height);
  };

  const take = (table) => {
    const plain = (value) => (value instanceof Map ? Object.fromEntries(value) : value);
    const { ids, changed, gone, come } = plain(table);
    for (const [id, row] of Object.entries(plain(changed))) rows.set(id, plain(row));
    if (ids) {
      order = [...ids];
    } else {
      const leaves = new Set(gone);
      order = order.filter((id) => !leaves.has(id));
      // In the order of their places, so that each place is right when its turn comes.
      const places = Object.entries(plain(come)).sort((a, b) => a[1] - b[1]);
      for (const [id, at] of places) order.splice(at, 0, id);
    }
    const left = new Set(order);
    for (const id of rows.keys()) if (!left.has(id)) rows.delete(id);
  };

  const draw = () => {
    spacer.style.height = `${order.length * height}px`;
    const first = Math.max(0, Math.floor(top / height) - 5);
    const last = Math.min(order.length, Math.ceil((top + view) / height) + 5);
    const wanted = new Map();
    for (let i = first; i < last; i++) wanted.set(order[i], i);
    for (const [id, row] of shown) {
      if (!wanted.has(id)) { row.remove(); shown.delete(id); }
    }
    for (const [id, i] of wanted) {
      let row = shown.get(id);
      if (!row) {
        row = document.createElement("div");
        row.id = `finding-${id}`;
        shown.set(id, row);
        list.append(row);
      }
      const selected = id === model.selected, { html, divider, settled } = rows.get(id);
      if (row.markup !== html) { row.innerHTML = html; row.markup = html; }
      row.className = divider ? "divider" : `row ${settled ? "settled" : ""}`;
      row.style.top = `${i * height}px`;
      row.dataset.id = id;
      row.setAttribute("role", divider ? "presentation" : "option");
      if (!divider) {
        row.setAttribute("aria-selected", selected);
        row.setAttribute("aria-posinset", i + 1);
        row.setAttribute("aria-setsize", order.length);
      }
    }
    if (shown.has(model.selected)) list.setAttribute("aria-activedescendant", `finding-${model.selected}`);
    else list.removeAttribute("aria-activedescendant");
  };

  const reveal = () => {
    const at = order.indexOf(model.selected);
    if (at < 0) return;
    if (at * height < top) scrollTo(at * height);
    if ((at + 1) * height > top + view) scrollTo((at + 1) * height - view);
  };

  list.addEventListener("click", (event) => {
    const row = event.target.closest(".row");
    if (row) model.send_msg({ do: "select", arg: row.dataset.id, fields: {} });
  });
  list.addEventListener("keydown", (event) => {
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!by) return;
    event.preventDefault();
    const ids = order.filter((id) => !rows.get(id).divider);
    const at = ids.indexOf(model.selected) + by;
    if (at >= 0 && at < ids.length) model.send_msg({ do: "select", arg: ids[at], fields: {} });
  });
  list.addEventListener("scroll", () => { top = list.scrollTop; draw(); }, { passive: true });
  list.addEventListener("pointermove", (event) => {
    pointer = event.clientY - list.getBoundingClientRect().top;
  });
  list.addEventListener("pointerleave", () => { pointer = null; });
  const observer = new ResizeObserver(() => { measure(); draw(); });
  observer.observe(list);
  let late = false;
  const drawing = drawnUnlessPressed(list, () => {
    spacer.style.height = `${order.length * height}px`;
    if (!late || pointer === null) reveal();
    late = false;
    draw();
  });
  model.on("msg:custom", (table) => {
    const rests = underPointer(), at = order.indexOf(rests);
    late = Boolean(table instanceof Map ? table.get("late") : table.late);
    take(table);
    if (late && rests) {
      spacer.style.height = `${order.length * height}px`; // so that it can be scrolled as far
      keepUnderPointer(rests, at);
    }
    drawing.ask();
  });
  model.on("selected", drawing.ask);
  model.on("remove", () => { observer.disconnect(); drawing.remove(); });
  measure();
  take(model.table);
  reveal();
  draw();
}
