// Handles: buttons on a drawing that a mouse, a finger or the arrow keys move; screen readers read them as sliders.
import { h } from "./dom.js";

// moves: {start(), by(dx, dy, event), key(right, up, coarse) , end()}; dx, dy in pixels since the start.
export function handle(box, name, label, moves, kind = "") {
  const made = h("button", { class: `handle ${kind}`, type: "button", role: "slider", "aria-label": label, "aria-valuenow": "0", "data-handle": name });
  let from = null;
  made.addEventListener("pointerdown", (event) => {
    if (event.button > 0) return;
    made.setPointerCapture(event.pointerId);
    from = [event.clientX, event.clientY];
    moves.start();
    made.focus({ preventScroll: true });
    event.preventDefault();
  });
  made.addEventListener("pointermove", (event) => {
    if (from) moves.by(event.clientX - from[0], event.clientY - from[1], event);
  });
  const end = () => {
    if (!from) return;
    from = null;
    moves.end();
  };
  made.addEventListener("pointerup", end);
  made.addEventListener("pointercancel", end);
  made.addEventListener("keydown", (event) => {
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!steps || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    moves.key(...steps, event.shiftKey ? 5 : 1);
  });
  box.append(made);
  return {
    element: made,
    place(x, y, value, text) {
      made.hidden = false;
      made.style.left = `${x}px`;
      made.style.top = `${y}px`;
      made.setAttribute("aria-valuenow", Number(value).toPrecision(4));
      made.setAttribute("aria-valuetext", text);
    },
    hide() {
      made.hidden = true;
    },
  };
}
