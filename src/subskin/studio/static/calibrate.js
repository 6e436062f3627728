// The view of a session at the bench: touch where the arrow is, and see what comes of it.
import { BenchMap } from "./bench_map.js";
import { card, fresh, h } from "./dom.js";
import { plain } from "./numbers.js";
import { say } from "./say.js";
import { ask, watch, whenOpen } from "./wire.js";

const RUN = { idle: "No session runs.", starting: "Opening the device …", ended: "The session has ended: accept it, or go back.", failed: "The session failed." };
const DO = { rest: "Hands off: the noise is measured.", touch: "Touch at the arrow.", hold: "Hold it.", lift: "Lift.", fit: "The touches are fitted." };
const MOST = 200000; // bytes of a table: the server takes messages of little more

export class CalibrateView {
  constructor(views) {
    this.views = views;
    this.told = {};
    this.map = new BenchMap();
    const field = (label, attributes) => {
      const id = fresh("bench");
      const input = h("input", { id, type: "text", autocomplete: "off", spellcheck: "false", ...attributes });
      return { input, row: h("div", { class: "field tall" }, h("label", { for: id }, label), h("div", { class: "entry text" }, input)) };
    };
    const button = (text, act, kind = "") => h("button", { class: `button ${kind}`, type: "button", onclick: act }, text);
    this.force = field("force of each touch", { placeholder: "unknown, but always alike" });
    this.accuracy = field("error of positions that is wanted", { value: "0.2 mm" });
    this.positions = field("where touches can be made", { placeholder: "all over the sensors; or -6 mm:6 mm:1 mm" });
    this.rest = field("time at rest, for the noise", { value: "2 s" });
    this.holding = field("time that a touch is held", { value: "0.5 s" });
    this.fit = field("what is fitted", { placeholder: "as usual; or gain, depth, origin" });
    this.driver = field("what the device sends", { placeholder: "as the file says; or lines?sensors=6" });
    const id = fresh("bench");
    this.file = h("input", { id, type: "file", accept: ".csv,text/csv", onchange: () => this.#read() });
    this.fileRow = h("div", { class: "field tall" }, h("label", { for: id }, "CSV with a column of positions, and one for each sensor"), this.file);
    this.start = button("Begin", () => this.#begin(), "primary");
    this.at = field("true position of this touch", { placeholder: "as asked" });
    this.at.input.addEventListener("change", () => this.at.input.value.trim() && this.#act("at", { position: this.at.input.value }));
    this.words = [button("Again", () => this.#act("again")), button("Skip", () => this.#act("skip")), button("End", () => this.#act("end"))];
    this.name = field("name of the file", { value: "calibrated.toml" });
    this.accept = button("Accept", () => this.#accept(), "primary");
    this.back = button("Go back", () => this.#act("back"));
    this.hold = button("Hold in Finger", () => this.views.show("finger", { text: this.kept }));
    this.run = h("p", { class: "status" });
    this.fault = h("p", { class: "fault", role: "alert", hidden: true });
    this.numbers = h("p", { class: "note" });
    this.doubts = h("div", {});
    this.said = h("ol", { class: "events" });
    this.changes = h("tbody", {});
    this.written = h("p", { class: "note" });
    this.#lay();
    whenOpen(() => this.shown && this.enter());
  }

  #lay() {
    const table = h("div", { class: "scroll wrap", tabindex: "0", role: "group", "aria-label": "What changed" }, h("table", {}, h("thead", {}, h("tr", {}, ["what", "in the file", "found", "standard error"].map((name) => h("th", { scope: "col" }, name)))), this.changes));
    this.changesCard = card("What changed", table);
    this.keepCard = card("Keep", this.name.row, h("div", { class: "buttons" }, this.accept, this.back, this.hold), this.written);
    this.guideCard = card("This touch", this.at.row, h("div", { class: "buttons" }, this.words));
    this.saidCard = card("Said", h("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": "What was said" }, this.said));
    this.beginCard = card("Session", h("p", { class: "note" }, "Touch by a thin straight edge across the row, on an area by a small tip, always with the same force."), h("div", { class: "fields" }, this.force.row, this.accuracy.row, this.positions.row, this.rest.row, this.holding.row, this.driver.row), h("div", { class: "buttons" }, this.start));
    this.without = h("p", { class: "note" }, "To be guided touch by touch, start the studio with a device: ", h("code", {}, "subskin studio finger.toml --port robot"), " simulates one.");
    this.fileCard = card("Touches made before", this.without, h("div", { class: "fields" }, this.fileRow));
    this.fitCard = card("Fit", h("div", { class: "fields" }, this.fit.row));
    const where = card("Where to touch", this.run, this.map.sheet.box, this.fault);
    const side = h("div", { class: "side" }, this.saidCard);
    const narrow = matchMedia("(max-width: 64rem)"); // there what is to be done comes first
    const first = [this.fitCard, this.beginCard, this.fileCard, this.guideCard, this.keepCard];
    const settle = () => (narrow.matches ? where.after(...first) : side.prepend(...first));
    this.element = h("div", { class: "view" }, h("div", { class: "stage" }, where, card("The fit so far", this.numbers, this.doubts), this.changesCard), side);
    narrow.addEventListener("change", settle);
    settle();
    this.hold.hidden = true;
    this.hear({ run: "idle" });
  }

  enter() {
    this.shown = true;
    ask({ view: "calibrate", do: "begin", finger: this.#finger() }, (said) => {
      if (this.#wrong(said.error)) return;
      this.port = said.port;
      this.without.hidden = Boolean(said.port);
      this.force.input.placeholder = `unknown, but always alike; or 40 ${said.units.force}`;
      this.map.begin(said);
      this.hear(this.told);
      watch("calibrate", (told) => this.hear(told));
    });
  }

  leave() {
    this.shown = false;
    watch("", null);
  }

  #finger() {
    return this.views.finger?.store.state?.text;
  }

  #begin() {
    const start = { force: this.force.input.value, accuracy: this.accuracy.input.value, positions: this.positions.input.value, rest: this.rest.input.value, hold: this.holding.input.value, fit: this.fit.input.value, driver: this.driver.input.value };
    this.#act("start", { start, finger: this.#finger() }, () => this.enter());
  }

  async #read() {
    const [file] = this.file.files;
    if (!file) return;
    const given = { name: file.name, text: await file.text(), fit: this.fit.input.value };
    this.file.value = ""; // the same file can be chosen again
    if (new Blob([JSON.stringify(given)]).size > MOST) this.#wrong(`${file.name} is larger than ${MOST / 1000} kB: use subskin calibrate, or fewer touches.`);
    else this.#act("file", { file: given, finger: this.#finger() }, () => this.enter());
  }

  #act(what, more = {}, done = () => {}) {
    ask({ view: "calibrate", do: what, ...more }, (said) => {
      if (!this.#wrong(said.error)) done(said);
    });
  }

  #accept() {
    this.#act("accept", { name: this.name.input.value.trim() }, (said) => {
      this.kept = said.text;
      this.hold.hidden = false;
      this.written.textContent = `Written: ${said.path}`;
      say(this.written.textContent, 0);
    });
  }

  #wrong(text) {
    this.fault.textContent = text ?? "";
    this.fault.hidden = !text;
    if (text) say(text, 0);
    return Boolean(text);
  }

  hear(told) {
    const before = this.told;
    this.told = told;
    const running = told.run === "running";
    this.run.textContent = running ? DO[told.phase] ?? "" : RUN[told.run];
    this.run.dataset.kind = { failed: "bad", running: "warn", ended: "good" }[told.run] ?? "";
    if (told.fault) this.#wrong(told.fault);
    const idle = told.run === "idle" || told.run === "failed";
    const open = !running && told.run !== "ended";
    this.beginCard.hidden = !open || !this.port;
    this.fileCard.hidden = this.fitCard.hidden = !open;
    this.guideCard.hidden = !running || told.phase === "fit";
    this.keepCard.hidden = idle || !(told.touches?.length > 1);
    this.accept.disabled = this.name.input.disabled = running;
    this.saidCard.hidden = !told.said?.length;
    this.changesCard.hidden = !told.changes?.length;
    if (running && before.run !== "running") [this.hold.hidden, this.written.textContent] = [true, ""];
    if (String(before.asked) !== String(told.asked)) this.at.input.value = "";
    const known = told.r2 !== null && told.r2 !== undefined;
    this.numbers.textContent = known ? `R² ${told.r2.toFixed(5)} of ${told.touches.length} touches${told.wanted ? `; positions are off by ${told.error === null ? "an unknown amount" : `${plain(1e3 * told.error)} mm`}, wanted ${plain(1e3 * told.wanted)} mm` : ""}.` : "Nothing yet: a few touches are needed.";
    this.doubts.replaceChildren(...(told.doubts ?? []).map((text) => h("p", { class: "note" }, text)));
    this.changes.replaceChildren(...(told.changes ?? []).map(([what, old, now, error]) => h("tr", {}, h("th", { scope: "row" }, what), ...[old, now, error && `± ${error}`].map((text) => h("td", {}, text)))));
    if (told.said?.at(-1) !== before.said?.at(-1) || told.said?.length !== before.said?.length) {
      this.said.replaceChildren(...(told.said ?? []).slice().reverse().map((text) => h("li", {}, text)));
      if (told.said?.length) say(told.said.at(-1));
    }
    this.map.show(told);
  }
}
