// The view of a finger: what a hand moves, what is asked of the server, and what is drawn of its answer.
import { Above } from "./above.js";
import { Answer, inWords } from "./answer.js";
import { Bars } from "./bars.js";
import { card, h } from "./dom.js";
import { fingerHandles } from "./finger_handles.js";
import { Form, segments } from "./form.js";
import { degrees } from "./numbers.js";
import { saveMenu } from "./save.js";
import { say } from "./say.js";
import { Section } from "./section.js";
import { Store, linked, where } from "./store.js";
import { ask, busy, follow, whenOpen } from "./wire.js";
import { Zoom } from "./zoom.js";

export class FingerView {
  constructor() {
    this.store = new Store("finger");
    this.unheard = []; // edits whose answer is on its way
    this.said = null;
    this.name = "finger.toml";
    this.section = new Section();
    this.above = new Above();
    this.bars = new Bars();
    this.zoom = new Zoom();
    this.answer = new Answer();
    this.touch = new Form((key, value) => this.set(key, value));
    this.finger = new Form((key, value) => this.look({}, { edits: [[key, value]] }, true, key));
    this.skin = new Form((key, value) => this.look({}, { edits: [[key, value]] }, true, key));
    this.fault = h("p", { class: "fault", role: "alert", hidden: true });
    this.show = h("select", { "aria-label": "What is drawn in the skin", onchange: () => this.look({ show: this.show.value }, {}, true) });
    this.find = segments("What is looked for", { locate: "line", fit: "with width" }, "locate", (find) => this.look({ find }, {}, true));
    this.noise = h("input", { type: "checkbox", onchange: () => this.look({ seed: this.noise.checked ? 0 : null }, {}, true) });
    this.draw = h("button", { class: "button", type: "button", onclick: () => this.look({ seed: (this.store.state.seed ?? 0) + 1 }, {}, true) }, "Draw again");
    this.aboveCard = card("From above", this.above.sheet.box);
    this.element = this.#laidOut();
    fingerHandles(this);
    whenOpen((back) => {
      this.sought = "";
      if (back && this.store.state) this.look({}, {}, false);
      else this.begin();
    });
    addEventListener("hashchange", () => where().view === "finger" && this.begin());
  }

  #laidOut() {
    const answer = card("Answer", [this.find.element], this.answer.element);
    const touch = card("Touch", this.touch.element, h("div", { class: "field" }, h("label", { class: "check" }, this.noise, "with noise"), this.draw));
    const section = card("Skin in section", [this.show], this.section.sheet.box, this.fault);
    this.trio = h("div", { class: "trio" }, this.aboveCard, h("div", { class: "duo" },
      card("Readings", this.bars.sheet.box, this.#key(["accent", "read"], ["found", "of the touch found"])),
      card("Estimate", this.zoom.sheet.box, this.#key(["found", "found, with 68 and 95 %"], ["truth", "the touch that pressed"], ["rival", "next best"]))));
    const stage = h("div", { class: "stage" }, section, this.trio,
      h("div", { class: "pair" }, card("Sensors", this.finger.element), card("Skin", this.skin.element)));
    const side = h("div", { class: "side" }, answer, touch, card("Keep", saveMenu(this)));
    const narrow = matchMedia("(max-width: 64rem)"); // there the answer follows the picture
    const settle = () => (narrow.matches ? section.after(h("div", { class: "pair" }, answer, touch)) : (answer.parentNode.matches(".pair") && answer.parentNode.remove(), side.prepend(answer, touch)));
    narrow.addEventListener("change", settle);
    settle();
    return h("div", { class: "view" }, stage, side);
  }

  #key(...texts) {
    return h("p", { class: "note key" }, texts.map(([kind, text]) => h("span", { class: kind }, text)));
  }

  async begin() {
    const state = where().view === "finger" ? await linked() : null;
    this.fromLink = Boolean(state);
    if (state) {
      this.store.state = state;
      this.look({}, {}, true);
    } else if (this.store.state) {
      this.look({}, {}, true);
    } else {
      this.#fresh();
    }
  }

  // The finger of the command.
  #fresh() {
    this.fromLink = false;
    ask({ view: "finger", do: "begin" }, (said) => {
      this.name = said.name;
      this.store.state = { text: said.begin.text };
      this.look({}, {}, true);
    });
  }

  // A finger from another view.
  take(state) {
    this.store.state = { ...state, touch: null };
    this.look({}, {}, true);
  }

  // change: of the state; how: edits, and whether a hand is at it. kept: the state stays, and can be undone.
  look(change, how, kept, key = "") {
    const state = { ...this.store.state, ...change };
    if (change.touch) this.store.state = state; // fields of a touch add up while the answer is on its way
    if (change.text === undefined) { // and so do edits of the finger
      if (how.edits && !how.moving) this.unheard.push(...how.edits);
      if (this.unheard.length) how = { ...how, edits: [...this.unheard] };
    }
    follow({ view: "finger", do: "look", state, how }, (said, more) => {
      this.unheard = this.unheard.filter((edit) => !how.edits?.includes(edit));
      this.hear(said, kept, more, key);
    });
  }

  set(key, value) {
    const touch = { ...this.store.state.touch };
    if (key === "y") touch.position = [value, ...touch.position.slice(1)];
    else if (key === "z") touch.position = [touch.position[0], value];
    else touch[key] = value;
    this.look({ touch }, {}, true);
  }

  hear(said, kept, more, key) {
    clearTimeout(this.seeking);
    if (said.error) {
      const own = key && ([this.finger, this.skin].some((form) => form.fault(key, said.error)));
      this.fault.textContent = own ? "" : said.error;
      this.fault.hidden = Boolean(own);
      say(said.error);
      if (!this.said && this.fromLink) this.#fresh(); // the link holds what cannot be
      return;
    }
    this.fault.hidden = true;
    this.said = said;
    this.store.state = said.state;
    if (kept) this.store.commit(said.state);
    this.draw_(said);
    this.#forms(said);
    if (said.coarse && !more && !this.held) this.refine();
    if (more) return;
    if (said.found.pending) this.seek(said);
    else say(inWords(said));
  }

  // The picture is there, and its answer takes longer: of a finger that is new, once the hand rests.
  seek(said) {
    const key = JSON.stringify(said.state);
    if (key === this.sought) return; // it is on its way
    this.seeking = setTimeout(() => {
      this.sought = key;
      follow({ view: "answer", do: "find", state: said.state }, ({ found, error }) => {
        if (this.sought === key) this.sought = "";
        if (JSON.stringify(this.said.state) !== key) return;
        this.said = { ...this.said, found: found ?? { ...said.found, words: error } };
        this.draw_(this.said);
        say(inWords(this.said));
      });
    }, 80);
  }

  // Nothing moves: the field is made finer, part by part.
  refine() {
    clearTimeout(this.finer);
    this.finer = setTimeout(() => {
      if (!this.held && !busy("finger")) this.look({}, { refine: true }, false); // what waits is not to be displaced
    }, 60);
  }

  draw_(said) {
    this.section.show(said);
    this.aboveCard.hidden = !said.area;
    this.trio.classList.toggle("row", !said.area);
    if (said.area) this.above.show(said);
    this.bars.show({ readings: said.readings, fitted: said.found.fitted, noise: said.noise, names: said.sensors.names, unit: said.units.reading });
    this.zoom.show(said.found.ellipse);
    this.answer.show(said.found, said.notes);
    this.place?.(said);
    this.section.sheet.describe(`The skin in section, ${said.skin.says}, with the ${said.fields[0].label} of the touch. ${inWords(said)}`);
  }

  #forms(said) {
    const { state } = said;
    const { touch } = state;
    const number = (key, label, value, scale, unit, step, least, most) => ({ key, label, kind: "number", value, scale, unit, step, least, most });
    const [force, angle] = [said.units.force, degrees];
    const entries = [
      { key: "family", label: "kind of contact", kind: "choice", value: touch.family, choices: said.families },
      number("force", "force", touch.force, 1, force, 0, 1e-9, 1e7),
      number("angle", "angle", touch.angle, angle, "°", 1, -1.4, 1.4),
      ...(said.area ? [number("azimuth", "azimuth", touch.azimuth, angle, "°", 5, -7, 7)] : []),
      number("y", "position y", touch.position[0], 1e3, "mm", 0.1, -10, 10),
      ...(said.area ? [number("z", "position z", touch.position[1], 1e3, "mm", 0.1, -10, 10)] : []),
      ...(said.wide ? [number("half_width", said.area ? "radius" : "half width", touch.half_width, 1e3, "mm", 0.05, 1e-6, 1)] : []),
    ];
    this.touch.show(entries);
    for (const [form, group] of [[this.finger, "Sensors"], [this.skin, "Skin"]]) {
      form.latest = said.form.filter((entry) => entry.group === group);
      form.show(form.latest);
    }
    const names = Object.entries(said.quantities);
    if (names.length !== this.show.options.length) this.show.replaceChildren(...names.map(([value, text]) => h("option", { value }, text)));
    this.show.value = state.show;
    this.find.set(state.find);
    this.find.name("locate", said.area ? "point" : "line");
    this.noise.checked = state.seed !== null;
    this.draw.disabled = state.seed === null;
  }

  undo() {
    this.unheard = [];
    if (this.store.undo()) this.look({}, {}, false);
  }

  redo() {
    this.unheard = [];
    if (this.store.redo()) this.look({}, {}, false);
  }
}
