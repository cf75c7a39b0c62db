// Listens to keys on the whole window before anybody else does. See keyboard.py for their names.
const TYPED_INTO = "textarea, select, [contenteditable], [contenteditable] *," +
  "input:not([type=range], [type=checkbox], [type=radio], [type=button], [type=submit]," +
  "[type=reset], [type=color], [type=file], [type=image])";
const CONTROLS = "button, a[href], summary, input, [role=button], [role=option], [role=tab]," +
  "[role=slider], [role=menuitem], [role=switch], [role=checkbox], [role=combobox]";
const OF_CONTROLS = new Set([" ", "Enter"]);
const OF_SLIDERS = new Set(["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End",
  "PageUp", "PageDown"]);

const IS_MAC = /^Mac/.test(navigator.platform);

export function nameOf(event) {
  const sign = event.key.length === 1;
  // On a Mac, Option makes signs such as [ on many keyboards, as AltGr does elsewhere.
  const byAltGr = event.getModifierState("AltGraph") || (IS_MAC && event.altKey && sign);
  if (event.altKey && !byAltGr) return null;
  const key = sign ? event.key.toLowerCase() : event.key;
  const isLetter = sign && key !== key.toUpperCase();
  const ctrl = (event.ctrlKey || event.metaKey) && !byAltGr ? "Ctrl+" : "";
  const shift = event.shiftKey && (isLetter || !sign) ? "Shift+" : "";
  return ctrl + shift + key;
}

// Where the key really goes: event.target stops at the border of a shadow DOM.
function targetOf(event) {
  const target = event.composedPath()[0];
  return target instanceof Element ? target : document.body;
}

// A button that was clicked has the focus too, but Space was not meant for it: only for one that was
// reached by Tab. (:focus-visible does not tell, any key turns it on.)
function isForControl(target, name, reachedByTab) {
  if (target.matches("input[type=range], [role=slider]") && OF_SLIDERS.has(name)) return true;
  return OF_CONTROLS.has(name) && reachedByTab && target.matches(CONTROLS);
}

class Listener {
  constructor(model) {
    this.model = model;
    this.number = 0;
    this.handled = 0;
    this.reachedByTab = false;
    this.listeners = {
      keydown: (event) => this.down(event),
      keyup: (event) => this.up(event),
      pointerdown: () => (this.reachedByTab = false),
    };
    for (const [type, listener] of Object.entries(this.listeners)) {
      window.addEventListener(type, listener, true);
    }
    model.on("msg:custom", (message) => {
      this.handled = message instanceof Map ? message.get("handled") : message.handled;
    });
    model.on("remove", () => this.remove());
  }

  remove() {
    for (const [type, listener] of Object.entries(this.listeners)) {
      window.removeEventListener(type, listener, true);
    }
  }

  takes(event) {
    if (event.isComposing || event.key === undefined) return null;
    const name = nameOf(event);
    const target = targetOf(event);
    if (name === null || target.matches(TYPED_INTO)) return null;
    if (isForControl(target, name, this.reachedByTab)) return null;
    return name in this.local || this.model.keys.includes(name) ? name : null;
  }

  get local() {
    const { local } = this.model;
    return local instanceof Map ? Object.fromEntries(local) : local;
  }

  down(event) {
    const target = targetOf(event);
    if (event.key === "Tab") this.reachedByTab = true;
    if (event.key === "Escape" && target.matches(TYPED_INTO)) {
      event.preventDefault();
      event.stopPropagation();
      target.blur();
      return;
    }
    const name = this.takes(event);
    if (name === null) return;
    event.preventDefault();
    event.stopPropagation();
    if (event.repeat && !this.model.repeating.includes(name)) return;
    if (name in this.local) {
      const { event: type, detail } = this.local[name];
      window.dispatchEvent(new CustomEvent(type, { detail }));
    } else if (!event.repeat || this.handled === this.number) {
      this.model.send_msg({ key: name, number: ++this.number });
    }
  }

  // Some browsers press a focused button when the key comes up.
  up(event) {
    if (this.takes(event) === null) return;
    event.preventDefault();
    event.stopPropagation();
  }
}

const before = new Map();

export function render({ model, el }) {
  before.get(model.id)?.remove();
  before.set(model.id, new Listener(model));
  el.style.display = "none";
}
