// Shows the HTML that Python made and sends intentions back: elements with data-do are the only
// controls, whatever part they stand in. Nothing is remembered here but the focus.
export function render({ model, el }) {
  const root = document.createElement("div");
  root.className = "root";
  el.append(root);

  const send = (target, value) => {
    const { do: name, arg } = target.dataset;
    const fields = {};
    const form = target.closest("[data-form]");
    if (form) {
      for (const input of form.querySelectorAll("[name]")) {
        fields[input.name] = input.type === "checkbox" ? input.checked : input.value;
      }
    }
    model.send_msg({ do: name, arg: value ?? arg ?? null, fields });
  };

  root.addEventListener("click", (event) => {
    const target = event.target.closest("[data-do]");
    if (!target || target.disabled || target.matches("input, select")) return;
    send(target);
  });
  root.addEventListener("input", (event) => {
    const target = event.target.closest("[data-do]");
    if (target && target.matches("input[type=range], select, input[type=checkbox]")) {
      send(target, target.type === "checkbox" ? target.checked : target.value);
    }
  });

  const place = (element) => element && `[data-do="${element.dataset.do}"]` +
    (element.dataset.arg === undefined ? "" : `[data-arg="${CSS.escape(element.dataset.arg)}"]`);

  const draw = () => {
    const focused = root.getRootNode().activeElement;
    const back = focused && root.contains(focused) ? place(focused.closest("[data-do]")) : null;
    root.innerHTML = model.html;
    const first = root.querySelector("[data-autofocus]");
    if (first) first.focus();
    else if (back) root.querySelector(back)?.focus({ preventScroll: true });
  };
  model.on("html", draw);
  draw();
}
