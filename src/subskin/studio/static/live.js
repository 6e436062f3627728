// The live view: a device as it feels, or a recording as it was.
import { Answer } from "./answer.js";
import { card, fresh, h } from "./dom.js";
import { segments } from "./form.js";
import { LiveMap } from "./live_map.js";
import { plain } from "./numbers.js";
import { say } from "./say.js";
import { Times } from "./times.js";
import { ask, watch, whenOpen } from "./wire.js";

const RUN = { idle: "Nothing runs.", starting: "Preparing the finger …", running: "Running.", ended: "It has ended.", failed: "It failed." };
const SPEEDS = { 0.25: "¼ ×", 1: "1 ×", 4: "4 ×", 20: "20 ×" };

export class LiveView {
  constructor(views) {
    this.views = views;
    this.map = new LiveMap();
    this.times = new Times("Force, position and angle over time");
    this.answer = new Answer(["quantity", "now"]);
    this.told = {};
    this.shown = false;
    this.#controls();
    this.element = this.#laidOut();
    whenOpen(() => this.shown && this.enter());
  }

  #controls() {
    const field = (label, attributes, note) => {
      const id = fresh("field");
      const input = h("input", { id, type: "text", autocomplete: "off", spellcheck: "false", ...attributes });
      return { input, row: h("div", { class: "field tall" }, h("label", { for: id }, label), h("div", { class: "entry text" }, input), note ? h("p", { class: "note" }, note) : null) };
    };
    this.port = field("device or recording", { placeholder: "demo" }, "demo, /dev/ttyACM0, tcp:host:port, ws:…, or a recording such as touch.parquet");
    this.driver = field("driver", { placeholder: "that of the file" }, "");
    this.slip = field("friction, to tell slip", { placeholder: "0.4..0.8" }, "");
    const button = (text, act, kind = "") => h("button", { class: `button ${kind}`, type: "button", onclick: act }, text);
    this.start = button("Start", () => this.begin(), "primary");
    this.stop = button("Stop", () => this.act("stop"));
    this.zero = button("Tare", () => this.act("zero"));
    this.record = button("Record", () => this.act("record", { on: !this.told.recording }));
    this.text = h("input", { type: "text", "aria-label": "Text of the mark", placeholder: "text of a mark", maxlength: "200" });
    this.mark = button("Mark", () => this.act("mark", { text: this.text.value }));
    this.run = h("p", { class: "status" });
    this.fault = h("p", { class: "fault", role: "alert", hidden: true });
    this.numbers = h("p", { class: "note" });
    this.kept = h("p", { class: "note" });
    this.at = h("input", { type: "range", min: "0", max: "1", step: "0.05", "aria-label": "Time in the recording" });
    this.at.addEventListener("input", () => { this.seeking = true; });
    this.at.addEventListener("change", () => {
      this.seeking = false;
      this.seek(Number(this.at.value));
    });
    this.speed = segments("Speed", SPEEDS, "1", (speed) => {
      this.factor = Number(speed);
      this.seek(this.told.at ?? 0);
    });
    this.factor = 1;
    this.pause = button("Pause", () => (this.told.run === "running" ? this.act("stop") : this.seek(this.told.at >= this.told.whole - 0.1 ? 0 : this.told.at)));
    this.clock = h("output", {});
    this.span = segments("Seconds that are seen", { 10: "10 s", 60: "1 min", 600: "10 min" }, "60", (span) => {
      this.times.span = Number(span);
      this.#scroll();
    });
    this.back = h("input", { type: "range", min: "0", max: "0", step: "0.5", value: "0", "aria-label": "Seconds back" });
    this.back.addEventListener("input", () => this.#scroll());
    this.events = h("ol", { class: "events" });
  }

  #laidOut() {
    this.playing = card("Playing", [this.clock], this.at, h("div", { class: "buttons" }, this.pause, this.speed.element));
    this.doing = card("Doing", h("div", { class: "buttons" }, this.zero, this.record), h("div", { class: "marking" }, this.text, this.mark), this.kept);
    const source = card("Source", h("div", { class: "fields" }, this.port.row, this.driver.row, this.slip.row), h("div", { class: "buttons" }, this.start, this.stop), this.run, this.fault);
    this.answerCard = card("Answer", this.answer.element);
    this.eventsCard = card("Events", h("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": "Events" }, this.events));
    [this.answerCard.hidden, this.eventsCard.hidden, this.back.hidden, this.playing.hidden] = [true, true, true, true];
    const stage = h("div", { class: "stage" }, card("Now", [this.numbers], this.map.sheet.box), card("Over time", [this.span.element], this.times.sheet.box, this.back));
    const side = h("div", { class: "side" }, this.answerCard, this.playing, this.doing, this.eventsCard);
    const narrow = matchMedia("(max-width: 64rem)"); // there the source comes first
    const settle = () => (narrow.matches ? stage : side).prepend(source);
    narrow.addEventListener("change", settle);
    settle();
    return h("div", { class: "view" }, stage, side);
  }

  enter() {
    this.shown = true;
    ask({ view: "live", do: "begin", finger: this.views.finger?.store.state?.text }, (said) => {
      if (said.error) {
        this.#wrong(said.error);
        return;
      }
      this.about = said;
      if (!this.port.input.value) this.port.input.value = said.first;
      this.map.begin(said);
      this.times.rows = [
        { label: `force [${said.units.found}]`, column: 1, scale: 1, low: 0 },
        { label: "position [mm]", column: 2, scale: 1e3 },
        { label: "angle [°]", column: 3, scale: 1 },
      ];
      this.times.clear();
      this.times.add(said.history);
      watch("live", (told) => this.hear(told));
    });
  }

  leave() {
    this.shown = false;
    watch("", null);
  }

  begin() {
    const start = { port: this.port.input.value.trim(), driver: this.driver.input.value.trim(), slip: this.slip.input.value.trim(), speed: this.factor };
    this.act("start", { start, finger: this.views.finger?.store.state?.text }, () => this.#again());
  }

  #again() {
    this.times.clear();
    this.map.begin(this.about);
  }

  act(what, more = {}, done = () => {}) {
    ask({ view: "live", do: what, ...more }, (said) => {
      this.#wrong(said.error ?? "");
      if (!said.error) done();
    });
  }

  seek(begin) {
    this.act("seek", { begin, speed: this.factor }, () => this.#again());
  }

  #wrong(text) {
    this.fault.textContent = text;
    this.fault.hidden = !text;
    if (text) say(text, 0);
  }

  hear(told) {
    const before = this.told;
    this.told = told;
    const running = told.run === "running";
    if (running && before.run !== "running") {
      ask({ view: "live", do: "begin" }, (said) => { // the finger may be that of the recording
        this.about = said;
        this.map.begin(said);
      });
    }
    this.run.textContent = told.run === "idle" ? RUN.idle : `${told.name}: ${RUN[told.run].toLowerCase()}`;
    this.run.dataset.kind = { running: "good", failed: "bad", starting: "warn" }[told.run] ?? "";
    if (told.fault) this.#wrong(told.fault);
    this.#enable(told, running);
    if (!told.steps) return;
    if (told.lasted < (before.lasted ?? 0) - 1) this.times.clear();
    this.times.add(told.steps);
    this.times.events = told.events;
    this.back.max = String(Math.max(0, Math.floor(this.times.lasted - this.times.span)));
    this.back.hidden = this.times.lasted <= this.times.span;
    this.times.sheet.draw();
    this.map.show(told);
    this.#numbers(told);
    this.#answer(told);
    this.#events(told.events, before.events ?? []);
  }

  #enable(told, running) {
    const device = told.kind === "device";
    this.stop.disabled = !(running || told.run === "starting");
    for (const one of [this.zero, this.record, this.mark]) one.disabled = !(device && running);
    this.record.textContent = told.recording ? "Stop recording" : "Record";
    this.doing.hidden = told.kind === "recording";
    this.playing.hidden = told.kind !== "recording";
    this.kept.textContent = told.recording ? `Recording to ${told.recording}` : told.recorded ? `Recorded: ${told.recorded}` : "A stream begins with the skin free; Tare says that it is free now.";
    if (told.kind !== "recording") return;
    this.pause.textContent = running ? "Pause" : "Play";
    this.at.max = String(told.whole);
    if (!this.seeking) this.at.value = String(told.at);
    this.clock.textContent = `${plain(told.at, 4)} of ${plain(told.whole, 4)} s`;
  }

  #numbers(told) {
    const parts = [`${plain(told.rate, 4)} frames/s`];
    if (told.kind === "device") parts.push(`${told.lost} lost`, `${told.bad} broken`, `answer after ${plain(1e3 * told.late, 2)} ms`);
    this.numbers.textContent = parts.join(" · ");
  }

  #answer(told) {
    this.answerCard.hidden = !told.found;
    if (!told.found) return;
    this.answer.show({ ...told.found, rows: told.found.rows, rival: null, fit: "" }, told.slip ? [`${told.slip.words}${told.slip.ratio === null ? "" : ` It uses ${plain(100 * told.slip.ratio, 2)} % of what friction holds.`}`] : []);
  }

  #events(events, before) {
    this.eventsCard.hidden = !events.length;
    const last = before.at(-1)?.number ?? 0;
    const fresh = events.filter((one) => one.number > last);
    if (!fresh.length && this.events.childElementCount) return;
    if (events.length && events[0].number > last) this.events.replaceChildren();
    const row = (one) => h("li", { "data-kind": one.kind }, h("span", {}, `${one.time.toFixed(2)} s`), ` ${one.text}`);
    for (const one of fresh.length ? fresh : events) this.events.prepend(row(one));
    while (this.events.childElementCount > 60) this.events.lastChild.remove();
    if (fresh.length) say(fresh.at(-1).text);
  }

  #scroll() {
    this.times.back = Number(this.back.value);
    this.times.sheet.draw();
  }
}
