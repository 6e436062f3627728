// Fields with their units: numbers in the units of people, kept in SI.
import { fresh, h } from "./dom.js";

const shown = (entry) => {
  const value = entry.value * entry.scale;
  return Number(value.toPrecision(5)).toString();
};

function numberField(entry, change) {
  const id = fresh("field");
  const input = h("input", { id, type: "text", inputmode: "decimal", autocomplete: "off", "data-key": entry.key });
  const fault = h("p", { class: "fault", id: `${id}-fault`, hidden: true });
  const unit = h("span", {}, entry.unit);
  const send = (value) => {
    if (!Number.isFinite(value)) {
      set({ ...entry }, "A number is needed.");
      return;
    }
    const within = Math.min(Math.max(value / entry.scale, entry.least ?? -Infinity), entry.most ?? Infinity);
    change(entry.key, entry.kind === "count" ? Math.round(within) : within);
  };
  input.addEventListener("change", () => send(Number(input.value.replace(",", ".").replace("−", "-"))));
  input.addEventListener("keydown", (event) => {
    const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (!way) return;
    event.preventDefault();
    const now = Number(input.value);
    const step = (entry.step || Math.abs(now) / 10 || 1) * (event.shiftKey && entry.kind !== "count" ? 10 : 1);
    send(Number((now + way * step).toPrecision(8)));
  });
  const row = h("div", { class: "field" }, h("label", { for: id }, entry.label),
    h("div", { class: entry.unit ? "entry" : "entry bare" }, input, unit));
  function set(next, wrong = "") {
    entry = next;
    unit.textContent = entry.unit;
    if (document.activeElement !== input || !wrong) input.value = shown(entry);
    fault.textContent = wrong;
    fault.hidden = !wrong;
    input.toggleAttribute("aria-invalid", Boolean(wrong));
    if (wrong) input.setAttribute("aria-describedby", fault.id);
  }
  set(entry);
  return { parts: [row, fault], set };
}

function choiceField(entry, change) {
  const id = fresh("field");
  const select = h("select", { id, "data-key": entry.key, onchange: () => change(entry.key, select.value) });
  function set(next) {
    entry = next;
    const names = Object.entries(entry.choices);
    const same = names.length === select.options.length && names.every(([k, v], i) => select.options[i].value === k && select.options[i].text === v);
    if (!same) select.replaceChildren(...names.map(([value, text]) => h("option", { value }, text)));
    select.value = entry.value;
  }
  set(entry);
  return { parts: [h("div", { class: "field" }, h("label", { for: id }, entry.label), select)], set };
}

// Fields that stay where they are while their values change, so that what has the focus keeps it.
export class Form {
  constructor(change) {
    this.change = change;
    this.element = h("div", { class: "fields" });
    this.fields = new Map();
    this.shape = "";
  }

  show(entries) {
    const shape = entries.map((entry) => `${entry.key}:${entry.kind}:${entry.label}`).join();
    if (shape !== this.shape) {
      this.shape = shape;
      const focused = document.activeElement?.dataset?.key;
      this.fields = new Map(entries.map((entry) => [entry.key, (entry.kind === "choice" ? choiceField : numberField)(entry, this.change)]));
      this.element.replaceChildren(...[...this.fields.values()].flatMap((field) => field.parts));
      if (focused) this.element.querySelector(`[data-key="${CSS.escape(focused)}"]`)?.focus();
      return;
    }
    for (const entry of entries) this.fields.get(entry.key).set(entry);
  }

  fault(key, text) {
    const field = this.fields.get(key);
    if (!field) return false;
    const entry = this.latest?.find((one) => one.key === key);
    if (entry) field.set(entry, text);
    return true;
  }
}

export function segments(label, choices, value, change) {
  const name = fresh("segments");
  const inputs = Object.entries(choices).map(([key, text]) => {
    const input = h("input", { type: "radio", name, value: key, onchange: () => change(key) });
    input.checked = key === value;
    return [input, h("label", {}, input, h("span", {}, text))];
  });
  const element = h("div", { class: "segments", role: "radiogroup", "aria-label": label }, inputs.map(([, row]) => row));
  return {
    element,
    set: (now) => inputs.forEach(([input]) => { input.checked = input.value === now; }),
    name: (key, text) => inputs.forEach(([input]) => { if (input.value === key) input.nextSibling.textContent = text; }),
  };
}
