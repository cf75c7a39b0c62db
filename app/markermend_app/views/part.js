// Shows the HTML that Python made and sends intentions back: elements with data-do are the only
// controls, whatever part they stand in. What stays the same is left alone, so that focus, what is
// being typed and what is being dragged survive.
function update(old, fresh) {
  const before = [...old.childNodes], after = [...fresh.childNodes];
  after.forEach((node, i) => {
    const there = before[i];
    if (!there) old.append(node);
    else if (there.nodeType !== node.nodeType || there.nodeName !== node.nodeName) {
      there.replaceWith(node);
    } else if (node.nodeType === Node.TEXT_NODE) {
      if (there.data !== node.data) there.data = node.data;
    } else {
      updateElement(there, node);
    }
  });
  before.slice(after.length).forEach((node) => node.remove());
}

function updateElement(old, fresh) {
  for (const { name } of [...old.attributes]) {
    if (!fresh.hasAttribute(name)) old.removeAttribute(name);
  }
  for (const { name, value } of fresh.attributes) {
    if (old.getAttribute(name) !== value) {
      old.setAttribute(name, value);
      // A field follows what Python says, unless somebody is at it.
      if (name === "value" && !old.matches(":focus, :active")) old.value = value;
    }
  }
  if (old.nodeName === "OPTION") old.selected = fresh.hasAttribute("selected");
  if (!old.isEqualNode(fresh)) update(old, fresh);
}

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
    model.send_msg({ do: name, arg: value ?? arg ?? null, fields: fieldsOf(target) });
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
    const first = form?.querySelector(".narrowed [data-do]:not([hidden])");
    const deed = first ?? form?.querySelector(".primary");
    if (deed) deed.click();
    else event.target.blur();
  });

  // A list beside the field shows only what has the words typed; the browser does it by itself.
  const narrow = (field) => {
    const words = field.value.toLowerCase().split(/\s+/);
    for (const entry of root.querySelectorAll(".narrowed [data-do]")) {
      const text = entry.textContent.toLowerCase();
      entry.hidden = !words.every((word) => text.includes(word));
    }
  };

  let opened = "";
  const draw = () => {
    const fresh = document.createElement("div");
    fresh.innerHTML = model.html;
    const dialog = fresh.querySelector("[data-dialog]")?.dataset.dialog ?? "";
    if (dialog !== opened) root.replaceChildren(...fresh.childNodes);
    else update(root, fresh);
    if (dialog !== opened && dialog) {
      (root.querySelector("[data-autofocus]") ?? root.querySelector("[role=dialog]"))?.focus();
    }
    opened = dialog;
  };
  model.on("html", draw);
  draw();
}
