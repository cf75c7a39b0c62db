import { drawnUnlessPressed, redraw, releaseSteady } from "./redraw.js";

// Shows the HTML that Python made and sends intentions back: elements with data-do are the only
// controls, whatever part they stand in.
export function render({ model, el }) {
  const root = document.createElement("div");
  root.className = "root";
  el.append(root);

  const fieldsOf = (target) => {
    const fields = {};
    for (const input of target.closest("[data-form]")?.querySelectorAll("[name]") ?? []) {
      fields[input.name] = input.type === "checkbox" ? input.checked : input.value;
    }
    return fields;
  };
  const send = (target, value) => {
    const { do: name, arg } = target.dataset;
    const of = target.closest("[data-steady]")?.dataset.steady ?? null;
    model.send_msg({ do: name, arg: value ?? arg ?? null, fields: fieldsOf(target), of });
  };

  root.addEventListener("click", (event) => {
    const target = event.target.closest("[data-do]");
    if (!target || target.disabled || target.matches("input, select")) return;
    send(target);
  });
  root.addEventListener("input", (event) => {
    const target = event.target.closest("[data-do]");
    if (target?.matches("input, select")) {
      send(target, target.type === "checkbox" ? target.checked : target.value);
    } else if (event.target.matches("[data-narrows]")) {
      narrow(event.target);
    }
  });
  // Enter does what the form's one primary button does, or leaves a field that stands alone.
  root.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" || !event.target.matches("input, textarea[data-enter]")) return;
    event.preventDefault();
    const form = event.target.closest("[data-form]");
    const first =
      form?.querySelector(".narrowed .begins:not([hidden])") ??
      form?.querySelector(".narrowed [data-do]:not([hidden])");
    const deed = first ?? form?.querySelector(".primary");
    if (deed) deed.click();
    else event.target.blur();
  });

  // A list beside the field shows only what has the words typed, what begins with them first; the
  // browser does it by itself.
  const narrow = (field) => {
    const typed = field.value.trim().toLowerCase();
    const words = typed.split(/\s+/);
    for (const entry of root.querySelectorAll(".narrowed [data-do]")) {
      const text = entry.textContent.trim().toLowerCase();
      entry.hidden = !words.every((word) => text.includes(word));
      entry.classList.toggle("begins", typed !== "" && text.startsWith(typed));
    }
  };

  let opened = "";
  const draw = () => {
    const fresh = document.createElement("div");
    fresh.innerHTML = model.html;
    const dialog = fresh.querySelector("[data-dialog]")?.dataset.dialog ?? "";
    if (dialog !== opened) {
      root.replaceChildren(...fresh.childNodes);
    } else {
      const focus = root.getRootNode().activeElement;
      redraw(root, fresh);
      // An element that is moved loses the focus.
      if (focus?.isConnected && root.contains(focus)) focus.focus({ preventScroll: true });
    }
    if (dialog !== opened && dialog) {
      (root.querySelector("[data-autofocus]") ?? root.querySelector("[role=dialog]"))?.focus();
    }
    opened = dialog;
  };
  const drawing = drawnUnlessPressed(root, draw);
  releaseSteady(root, drawing.ask);
  model.on("html", drawing.ask);
  model.on("remove", drawing.remove);
  draw();
}
