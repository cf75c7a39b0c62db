// Brings elements up to date with HTML that was made anew. What stays the same is left alone, so
// that focus, what is being typed and what is being dragged survive. A child is the one it was by
// its data-key or id, others by their place.
//
// A list with data-steady keeps its order while somebody is about to choose from it, as long as the
// value of data-steady is the same: new values are shown, but no row moves under the pointer.
const keyOf = (node) => node.dataset?.key || node.id || null;

function holds(old, fresh) {
  const subject = old.dataset?.steady;
  if (subject === undefined || subject !== fresh.dataset.steady) return false;
  const focus = old.getRootNode().activeElement;
  return (focus && old.contains(focus)) || (old.touched === subject && old.matches(":hover"));
}

// A row that is no more stays in its place, but nothing can be done with it.
function gone(row) {
  const left = row.cloneNode(true);
  left.inert = true;
  return left;
}

function arranged(old, fresh, held) {
  const nodes = [...fresh.childNodes];
  if (!held) return nodes;
  const wanted = new Map(nodes.filter(keyOf).map((node) => [keyOf(node), node]));
  const there = [...old.children].filter(keyOf);
  const kept = there.map((row) => wanted.get(keyOf(row)) ?? gone(row));
  const known = new Set(kept);
  return [...kept, ...nodes.filter((node) => !known.has(node))];
}

export function redraw(old, fresh, held = false) {
  const keyed = new Map(), others = [];
  for (const child of old.childNodes) {
    if (keyOf(child)) keyed.set(keyOf(child), child);
    else others.push(child);
  }
  old.behind = held;
  let at = old.firstChild;
  for (const node of arranged(old, fresh, held)) {
    const key = keyOf(node);
    let child = key ? keyed.get(key) : others.shift();
    keyed.delete(key);
    if (child && child.nodeName === node.nodeName) {
      if (child.nodeType === Node.TEXT_NODE) {
        if (child.data !== node.data) child.data = node.data;
      } else {
        redrawElement(child, node);
      }
    } else {
      if (child === at) at = child?.nextSibling ?? null;
      child?.remove();
      child = node;
    }
    if (child === at) at = at.nextSibling;
    else old.insertBefore(child, at);
  }
  for (const child of [...keyed.values(), ...others]) child.remove();
}

function redrawElement(old, fresh) {
  const held = holds(old, fresh);
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
  if (!old.isEqualNode(fresh)) redraw(old, fresh, held);
}

// Calls `draw` whenever it is asked to, but not while the pointer is down in `root`: what was
// pressed must be there when it is let go. Fields show what they do while they are dragged.
export function drawnUnlessPressed(root, draw) {
  let pressed = false, waiting = false;
  const ask = () => {
    waiting = pressed;
    if (!pressed) draw();
  };
  const release = (event) => {
    // Elements lose the focus when the pointer goes down; only the window's own blur ends a press.
    if (!pressed || (event.type === "blur" && event.target !== window)) return;
    pressed = false;
    // The click comes after the pointer is up, in the same turn.
    setTimeout(() => { if (waiting && !pressed) ask(); }, 0);
  };
  root.addEventListener("pointerdown", (event) => {
    if (event.isPrimary && !event.target.closest("input, select, textarea")) pressed = true;
  });
  const ends = ["pointerup", "pointercancel", "dragend", "blur"];
  for (const type of ends) window.addEventListener(type, release, true);
  const remove = () => {
    for (const type of ends) window.removeEventListener(type, release, true);
  };
  return { ask, remove };
}

// Notes which lists the pointer moves in, and asks for another drawing once it, and the focus, have
// left one that is behind.
export function releaseSteady(root, ask) {
  root.addEventListener("pointermove", (event) => {
    if (!event.movementX && !event.movementY) return; // the page moved, not the pointer
    const list = event.target.closest("[data-steady]");
    if (list) list.touched = list.dataset.steady;
  });
  const left = () => setTimeout(() => {
    const behind = [...root.querySelectorAll("[data-steady]")].filter((list) => list.behind);
    if (behind.some((list) => !holds(list, list))) ask();
  }, 0);
  root.addEventListener("pointerout", left);
  root.addEventListener("focusout", left);
}
