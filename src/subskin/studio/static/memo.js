// The view of the memo: its figures with numbers to move, and the printed equation beside the corrected one.
import { card, h } from "./dom.js";
import { formula, isFormula } from "./formula.js";
import { Plot } from "./plot.js";
import { say } from "./say.js";
import { Slider } from "./slider.js";
import { Store, linked, where } from "./store.js";
import { follow, whenOpen } from "./wire.js";

const KIND = { correct: "good", caveat: "warn", "first order": "warn", incomplete: "warn", rounded: "warn", wrong: "bad" };
const JUDGED = { correct: "correct", caveat: "correct, with a caveat", "first order": "correct to first order", incomplete: "incomplete", rounded: "rounded the unsafe way", wrong: "wrong" };

export class MemoView {
  constructor() {
    this.store = new Store("memo");
    this.figure = "";
    this.choose = h("select", { "aria-label": "Figure", onchange: () => this.look({ figure: this.choose.value, values: {} }, true) });
    this.words = h("p", { class: "lead" });
    this.panels = h("div", { class: "stage" });
    this.numbers = h("div", { class: "fields" });
    this.told = h("div");
    this.equations = h("div", { class: "stage" });
    this.numbersCard = card("Numbers", this.numbers, this.told);
    const reset = h("button", { class: "button", type: "button", onclick: () => this.look({ figure: this.figure, values: {} }, true) }, "As in the memo");
    this.numbersCard.append(h("div", { class: "buttons" }, reset));
    this.element = h("div", {},
      h("div", { class: "picker" }, this.choose), this.words,
      h("div", { class: "view" }, this.panels, h("div", { class: "side" }, this.numbersCard, this.equations)));
    this.plots = [];
    this.sliders = new Map();
    whenOpen(() => this.enter());
  }

  async enter() {
    if (where().view !== "memo") return;
    const state = (await linked()) ?? this.store.state ?? { figure: "2", values: {} };
    this.look(state, true);
  }

  look(state, kept) {
    follow({ view: "memo", do: "look", state }, (said, more) => this.hear(said, kept, more));
  }

  move(key, value, kept) {
    const now = this.store.state;
    this.store.state = { figure: now.figure, values: { ...now.values, [key]: value } };
    this.look(this.store.state, kept);
  }

  hear(said, kept, more) {
    if (said.error) {
      say(said.error);
      return;
    }
    if (!more) this.store.state = said.state;
    if (kept) this.store.commit(said.state);
    if (said.state.figure !== this.figure || this.plots.length !== said.panels.length) this.#fresh(said);
    said.panels.forEach((panel, i) => {
      this.plots[i].plot.show(panel);
      this.#key(this.plots[i].key, panel);
    });
    if (!more) said.numbers.forEach((number) => this.sliders.get(number.key).set(number.value));
    this.told.replaceChildren(...said.told.map((text) => h("p", { class: "note" }, text)));
    if (!more) say(said.told.slice(0, 2).join(" "));
  }

  #fresh(said) {
    this.figure = said.state.figure;
    this.choose.replaceChildren(...Object.entries(said.figures).map(([value, text]) => h("option", { value }, text)));
    this.choose.value = this.figure;
    this.words.textContent = said.words;
    this.plots = said.panels.map((panel) => {
      const plot = new Plot(panel.title);
      const key = h("p", { class: "note key" });
      return { plot, key, element: card(panel.title, plot.sheet.box, key) };
    });
    this.panels.replaceChildren(...this.plots.map((one) => one.element));
    this.sliders = new Map(said.numbers.map((number) => [number.key, new Slider(number, (key, value, kept) => this.move(key, value, kept))]));
    this.numbers.replaceChildren(...[...this.sliders.values()].map((slider) => slider.element));
    this.equations.replaceChildren(...said.equations.map((one) => this.#equation(one)));
  }

  #key(element, panel) {
    const seen = new Set();
    const entries = [...panel.curves.map((one) => [`line k${one.kind}`, one.label]), ...panel.marks.filter((one) => one.label).map((one) => [`dot k${one.kind}`, one.label])]
      .filter(([kind, label]) => !seen.has(kind + label) && seen.add(kind + label));
    element.replaceChildren(...entries.map(([kind, label]) => h("span", { class: kind }, label)));
  }

  #equation(one) {
    const shown = [["As printed", one.printed], ["Corrected", one.corrected]].filter(([, tree]) => isFormula(tree));
    return card(/^\d/.test(one.number) ? `${/[ ,]/.test(one.number) ? "Equations" : "Equation"} ${one.number}` : one.number,
      h("p", {}, one.subject),
      h("p", { class: "status", "data-kind": KIND[one.judgement] }, JUDGED[one.judgement]),
      shown.map(([label, tree]) => h("div", { class: "formula" }, h("h3", {}, label), h("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": `${label}, equation ${one.number}` }, formula(tree, true)))),
      one.finding.map((line) => h("p", { class: "note" }, line.map((part) => (typeof part === "string" ? part : formula(part))))));
  }

  undo() {
    const state = this.store.undo();
    if (state) this.look(state, false);
  }

  redo() {
    const state = this.store.redo();
    if (state) this.look(state, false);
  }
}
