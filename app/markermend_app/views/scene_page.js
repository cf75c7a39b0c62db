// How the view and the rest of the page talk within the browser, without Python in between.
// The events are described in scene.py.
export function connectPage({ onSeek, onStep, onPlay }) {
  const handlers = {
    "markermend:seek": ({ detail }) => onSeek(detail),
    "markermend:step": ({ detail }) => onStep(detail.by),
    "markermend:play": ({ detail }) => onPlay(detail?.playing),
  };
  for (const [name, handle] of Object.entries(handlers)) window.addEventListener(name, handle);
  return () => {
    for (const [name, handle] of Object.entries(handlers)) window.removeEventListener(name, handle);
  };
}

export function announceFrame(detail) {
  window.dispatchEvent(new CustomEvent("markermend:frame", { detail }));
}

// Calls `send` at once, then at most every `interval` ms, and always with the last value.
export function throttled(send, interval) {
  let timer = 0, last = -Infinity, waiting;
  const flush = () => {
    timer = 0;
    last = performance.now();
    send(waiting);
  };
  return {
    push(value) {
      waiting = value;
      if (!timer) timer = setTimeout(flush, Math.max(0, last + interval - performance.now()));
    },
    now(value) {
      clearTimeout(timer);
      waiting = value;
      flush();
    },
    stop: () => clearTimeout(timer),
  };
}
