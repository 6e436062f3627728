// The finger at the bench: its sensors as they feel and as they are, touches that were made, and where the next goes.
import { Sheet, arrow, line } from "./canvas.js";
import { clip, plain, ticks } from "./numbers.js";
import { colour } from "./theme.js";

const COLOUR = { ok: "accent", weak: "warn", dead: "bad" };

const SIDE = 44; // on both sides of an area, for the marks of z

export class BenchMap {
  constructor() {
    this.about = null;
    this.told = {};
    this.sheet = new Sheet("The finger and the next touch", (width) => this.#height(width), (pen, w, h) => this.#draw(pen, w, h));
  }

  begin(about) {
    this.about = about;
    this.sheet.draw();
  }

  show(told) {
    this.told = told;
    const ill = (told.health ?? []).map((state, i) => (state === "ok" ? "" : `${this.about.sensors.names[i]} is ${state}`)).filter(Boolean);
    const next = told.asked === null || told.asked === undefined || told.phase === "done" ? "" : `Next touch at ${[told.asked].flat().map((v) => `${plain(1e3 * v)} mm`).join(", ")}. `;
    this.sheet.describe(`${next}${told.touches?.length ?? 0} touches taken. ${ill.length ? ill.join(", ") : "No sensor is weak or dead"}.`);
    this.sheet.draw();
  }

  #height(width) {
    if (!this.about?.area) return clip(0.42 * width, 200, 360);
    const { y, v } = this.#ends();
    return clip(((width - 2 * SIDE) * (v[1] - v[0])) / (y[1] - y[0]) + 40, 200, 600);
  }

  // What is seen: along y, and down: depths, or on an area z.
  #ends() {
    const { sensors, area } = this.about;
    const deep = Math.max(...sensors.depth);
    const beyond = (values, by) => [Math.min(...values) - by * deep, Math.max(...values) + by * deep];
    return area ? { y: beyond(sensors.y, 1.2), v: beyond(sensors.z, 1.2) } : { y: beyond(sensors.y, 1.6), v: [-0.9 * deep, 1.7 * deep] };
  }

  #draw(pen, width, height) {
    if (!this.about) return;
    const { sensors, area } = this.about;
    const { y, v } = this.#ends();
    const k = Math.min((width - 2 * SIDE) / (y[1] - y[0]), (height - 40) / (v[1] - v[0]));
    const wide = area ? k : (width - 20) / (y[1] - y[0]);
    const px = (at) => width / 2 + wide * (at - (y[0] + y[1]) / 2);
    const tall = area ? k : (height - 40) / (v[1] - v[0]);
    const py = area ? (at) => 8 + tall * (v[1] - at) : (at) => 8 + tall * (at - v[0]);
    pen.fillStyle = colour("skin");
    const top = area ? 8 : py(0);
    pen.fillRect(px(y[0]), top, px(y[1]) - px(y[0]), (area ? py(v[0]) : height - 32) - top);
    pen.strokeStyle = colour("ink");
    pen.lineWidth = 1.6;
    if (!area) line(pen, px(y[0]), top, px(y[1]), top);
    this.#sensors(pen, px, (i) => py(area ? sensors.z[i] : sensors.depth[i]));
    pen.fillStyle = colour("soft");
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const marks = ticks(1e3 * y[0], 1e3 * y[1], width / 90);
    for (const mark of marks) pen.fillText((area && mark === marks[0] ? "y " : "") + plain(mark) + (mark === marks.at(-1) ? " mm" : ""), px(mark / 1e3), height - 24);
    if (area) this.#upwards(pen, v, px(y[0]), py);
    pen.textAlign = "center";
    const spot = (at) => (area ? [px(at[0]), py(at[1])] : [px(at), top]);
    for (const at of this.told.touches ?? []) {
      const [x, h] = spot(at);
      pen.beginPath();
      pen.arc(x, h, 3, 0, 2 * Math.PI);
      pen.fill();
    }
    const { asked, phase } = this.told;
    if (asked !== null && asked !== undefined && (phase === "touch" || phase === "hold")) this.#next(pen, ...spot(asked), phase);
    pen.textAlign = "left";
  }

  #upwards(pen, v, left, py) {
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    const marks = ticks(1e3 * v[0], 1e3 * v[1], Math.abs(py(v[1]) - py(v[0])) / 60);
    for (const mark of marks) pen.fillText((mark === marks.at(-1) ? "z " : "") + plain(mark), left - 6, py(mark / 1e3));
  }

  #sensors(pen, px, py) {
    const { sensors } = this.about;
    const step = sensors.y.length > 1 ? Math.abs(px(sensors.y[1]) - px(sensors.y[0])) || 40 : 40;
    sensors.y.forEach((at, i) => {
      const state = this.told.health?.[i] ?? "ok";
      const felt = clip(Math.log10(Math.max(Math.abs(this.told.level?.[i] ?? 0), 1)) / 3, 0, 1);
      const [x, h] = [px(at), py(i)];
      pen.strokeStyle = pen.fillStyle = colour(COLOUR[state]);
      pen.lineWidth = 2.5;
      pen.beginPath();
      pen.arc(x, h, 9, 0, 2 * Math.PI);
      pen.stroke();
      pen.beginPath();
      pen.arc(x, h, 7 * felt, 0, 2 * Math.PI);
      pen.fill();
      pen.textAlign = "center";
      pen.textBaseline = "top";
      pen.fillStyle = colour(state === "ok" ? "soft" : COLOUR[state]);
      if (state !== "ok" || step > 30 || i % Math.ceil(30 / step) === 0) pen.fillText(state === "ok" ? sensors.names[i] : `${sensors.names[i]} ${state}`, x, h + 13);
    });
  }

  #next(pen, x, y, phase) {
    pen.strokeStyle = pen.fillStyle = colour("found");
    if (this.about.area) {
      pen.lineWidth = 3;
      pen.beginPath();
      pen.arc(x, y, phase === "hold" ? 10 : 16, 0, 2 * Math.PI);
      pen.stroke();
      line(pen, x - 22, y, x + 22, y);
      line(pen, x, y - 22, x, y + 22);
    } else arrow(pen, x, phase === "hold" ? 12 : 2, x, phase === "hold" ? y : y - 8, 4, 14);
  }
}
