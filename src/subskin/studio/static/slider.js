// A number that a hand moves, with the value beside it.
import { fresh, h } from "./dom.js";
import { plain } from "./numbers.js";

export class Slider {
  constructor(number, change) {
    const id = fresh("slider");
    this.number = number;
    this.input = h("input", { id, type: "range", min: String(number.least), max: String(number.most), step: String(number.step) });
    this.value = h("output", { for: id });
    this.element = h("div", { class: "slider" }, h("label", { for: id }, number.label), this.value, this.input);
    this.input.addEventListener("input", () => change(number.key, Number(this.input.value), false));
    this.input.addEventListener("change", () => change(number.key, Number(this.input.value), true));
    this.set(number.value);
  }

  set(value) {
    if (document.activeElement !== this.input || Math.abs(Number(this.input.value) - value) > this.number.step) this.input.value = String(value);
    const { unit } = this.number;
    this.value.textContent = `${plain(value, 4)}${unit && unit !== "°" && unit !== "%" ? " " : ""}${unit}`;
    this.input.setAttribute("aria-valuetext", this.value.textContent);
  }
}
