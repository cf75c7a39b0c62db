// The clock of an exercise: minutes and seconds since it began, counted here and nowhere else.
export function render({ model, el }) {
  const shown = document.createElement("div");
  shown.className = "stopwatch num";
  shown.setAttribute("role", "timer");
  shown.setAttribute("aria-label", "Time so far");
  el.append(shown);
  let begun = Date.now();
  const tick = () => {
    const seconds = Math.max(0, Math.floor((Date.now() - begun) / 1000));
    const rest = String(seconds % 60).padStart(2, "0");
    shown.hidden = !model.runs;
    shown.textContent = `${Math.floor(seconds / 60)}:${rest}`;
  };
  const start = () => {
    begun = Date.now() - 1000 * model.elapsed_s;
    tick();
  };
  model.on("elapsed_s", start);
  model.on("runs", start);
  const timer = setInterval(tick, 1000);
  model.on("remove", () => clearInterval(timer));
  start();
}
