// The view of a search: goals, the search as it runs, the map, the fingers that it found.
import { card, fresh, h } from "./dom.js";
import { DesignMap } from "./design_map.js";
import { plain } from "./numbers.js";
import { download } from "./save.js";
import { say } from "./say.js";
import { ask, watch, whenOpen } from "./wire.js";

const RUN = { idle: "Nothing has been searched yet.", searching: "Trying skins, kinds, depths, pitches and counts …", ranking: "Looking closely at the best …", done: "The search has ended.", stopped: "Stopped. Start goes on from here.", failed: "The search failed." };

export class DesignView {
  constructor(views) {
    this.views = views;
    this.told = {};
    this.text = "";
    this.which = { skin: 0, sensor: 0, layout: 0 };
    this.fields = h("div", { class: "fields" });
    const id = fresh("goals");
    this.goals = h("textarea", { id, rows: "16", spellcheck: "false", class: "code" });
    this.goals.addEventListener("change", () => this.#typed());
    this.fault = h("p", { class: "fault", role: "alert", hidden: true });
    this.run = h("p", { class: "status" });
    this.bar = h("progress", { max: 1, value: 0, "aria-label": "How far the search is" });
    this.start = h("button", { class: "button primary", type: "button", onclick: () => this.#act("start", { text: this.text }) }, "Start");
    this.stop = h("button", { class: "button", type: "button", onclick: () => this.#act("stop") }, "Stop");
    this.map = new DesignMap((cell) => this.#cell(cell));
    this.pick = Object.fromEntries([["skin", "Skin"], ["sensor", "Kind of sensor"], ["layout", "Count of sensors"]].map(([key, label]) => [key, h("select", { "aria-label": label, onchange: () => this.#look({ [key]: Number(this.pick[key].value) }) })]));
    this.said = h("p", {});
    this.hold = h("button", { class: "button primary", type: "button", onclick: () => this.#hold({ ...this.which, depth: this.cell.at[0], pitch: this.cell.at[1] }) }, "Hold in Finger");
    this.mapCard = card("Map of designs", h("div", { class: "picks" }, Object.values(this.pick)), this.map.sheet.box, h("div", { class: "held" }, this.said, this.hold));
    this.fingers = h("div", { class: "stage" });
    const details = h("details", {}, h("summary", {}, "All goals, as a file"), h("label", { class: "hidden", for: id }, "goals.toml"), this.goals,
      h("div", { class: "buttons" }, h("button", { class: "button", type: "button", onclick: () => download("goals.toml", this.text) }, "Save goals.toml")));
    this.element = h("div", { class: "view" },
      h("div", { class: "stage" }, card("Search", this.run, this.bar, h("div", { class: "buttons" }, this.start, this.stop), this.fault), this.mapCard, this.fingers),
      h("div", { class: "side" }, card("Goals", this.fields), h("section", { class: "card" }, details)));
    this.mapCard.hidden = true;
    whenOpen(() => this.shown && this.enter());
  }

  enter() {
    this.shown = true;
    if (!this.text) ask({ view: "design", do: "begin" }, (said) => this.#form(said));
    watch("design", (told) => this.hear(told));
  }

  leave() {
    this.shown = false;
    watch("", null);
  }

  #form(said) {
    if (this.#wrong(said.error)) return;
    this.text = said.text;
    this.goals.value = said.text;
    const inputs = [...this.fields.querySelectorAll("input")];
    if (inputs.length === said.form.length && said.form.every((field, i) => inputs[i].dataset.key === field.key)) {
      said.form.forEach((field, i) => inputs[i] !== document.activeElement && (inputs[i].value = field.value)); // who types goes on
      return;
    }
    this.fields.replaceChildren(...said.form.map((field) => {
      const id = fresh("goal");
      const input = h("input", { id, type: "text", "data-key": field.key, value: field.value, autocomplete: "off", spellcheck: "false" });
      input.addEventListener("change", () => ask({ view: "design", do: "edit", text: this.text, key: field.key, value: input.value }, (answer) => this.#form(answer)));
      return h("div", { class: "field goal" }, h("label", { for: id }, field.label), h("div", { class: "entry text" }, input));
    }));
  }

  #typed() {
    ask({ view: "design", do: "check", text: this.goals.value }, (said) => this.#form(said));
  }

  #act(what, more = {}) {
    ask({ view: "design", do: what, ...more }, (said) => this.#wrong(said.error));
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
    const busy = told.run === "searching" || told.run === "ranking";
    this.run.textContent = RUN[told.run];
    this.run.dataset.kind = { done: "good", failed: "bad", stopped: "warn" }[told.run] ?? "";
    this.bar.max = told.total;
    this.bar.value = told.done;
    this.bar.hidden = !busy;
    [this.start.disabled, this.stop.disabled] = [busy, !busy];
    if (told.fault) this.#wrong(told.fault);
    if (told.run !== before.run) say(RUN[told.run]);
    this.mapCard.hidden = !told.map;
    if (told.map && (!before.map || told.run !== before.run)) this.#choices(told.map, told.study);
    if (told.study && !before.study) this.#found(told.study);
    if (!told.study) this.fingers.replaceChildren();
  }

  #choices(map, study) {
    const fill = (select, names) => select.replaceChildren(...names.map(([value, text]) => h("option", { value: String(value) }, text)));
    fill(this.pick.skin, map.skins.map((name, i) => [i, name]));
    fill(this.pick.sensor, map.sensors.map((name, i) => [i, name]));
    fill(this.pick.layout, map.layouts.map((name, i) => [i, name]));
    const best = study?.fingers[0];
    this.#look(best ? { skin: best.skin, sensor: best.sensor, layout: best.layout } : { skin: 0, sensor: 0, layout: map.layouts.length - 1 }, true);
  }

  #look(change, anew = false) {
    this.which = { ...this.which, ...change };
    ask({ view: "design", do: "map", ...this.which }, (said) => {
      if (this.#wrong(said.error)) return;
      this.which = { skin: said.skin, sensor: said.sensor, layout: said.layout };
      for (const key of Object.keys(this.pick)) this.pick[key].value = String(said[key]);
      if (anew) this.map.map = null;
      this.map.show(said);
    });
  }

  #cell(cell) {
    this.cell = cell;
    const ratio = cell.ratio === null ? "there is no room for it" : cell.ratio <= 1 ? "it meets the goals of the map" : `its worst value is ${plain(cell.ratio, 2)} times what was wanted${cell.ratio < 30 ? "" : ", or more"}`;
    this.said.textContent = `${plain(1e3 * cell.depth)} mm deep, ${plain(1e3 * cell.pitch)} mm apart: ${ratio}.`;
    this.hold.disabled = cell.ratio === null;
  }

  #hold(design) {
    ask({ view: "design", do: "hold", ...design }, (said) => {
      if (!this.#wrong(said.error)) this.views.show("finger", { text: said.text });
    });
  }

  #found(study) {
    const rows = study.rows.map((row, i) => h("tr", {}, row.map((cell, k) => (k ? h("td", {}, cell) : h("th", { scope: "row" }, cell))),
      h("td", {}, h("button", { class: "button", type: "button", "aria-label": `Hold finger ${i + 1}`, onclick: () => this.#hold({ finger: i }) }, "Hold"))));
    const table = h("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": "Fingers, ranked" }, h("table", {}, h("thead", {}, h("tr", {}, study.columns.map((name) => h("th", { scope: "col" }, name || "#")), h("th", { scope: "col" }, "keep"))), h("tbody", {}, rows)));
    const report = h("button", { class: "button", type: "button", onclick: () => {
      report.disabled = true;
      report.textContent = "Writing …";
      ask({ view: "design", do: "report" }, (said) => {
        report.disabled = false;
        report.textContent = "Download the report";
        if (!this.#wrong(said.error)) download("report.html", said.report, "text/html");
      });
    } }, "Download the report");
    this.fingers.replaceChildren(
      card("Fingers", h("p", { class: "status", "data-kind": study.fingers[0].meets ? "good" : "warn" }, study.verdict), study.remedies.map((text) => h("p", { class: "note" }, text)), table, h("p", { class: "note" }, study.legend), h("div", { class: "buttons" }, report)),
      card("Why finger 1 is as it is", study.fingers[0].reasons.map((text) => h("p", { class: "note" }, text))));
  }
}
