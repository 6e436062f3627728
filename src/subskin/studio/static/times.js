// The last minutes: one curve below the other, on one axis of time.
import { Sheet, line } from "./canvas.js";
import { plain, ticks } from "./numbers.js";
import { colour } from "./theme.js";

const LEFT = 62;
export const STEP = 0.05; // seconds of a step of the server's history

export class Times {
  // rows: [{label, column, scale, low?}]
  constructor(label) {
    this.rows = [];
    this.steps = [];
    this.span = 60;
    this.back = 0;
    this.events = [];
    this.sheet = new Sheet(label, () => 26 + 104 * Math.max(this.rows.length, 1), (pen, w, h) => this.#draw(pen, w, h));
  }

  // Steps come in order; some may be known already.
  add(steps) {
    const last = this.steps.at(-1)?.[0] ?? -1;
    for (const step of steps) if (step[0] > last) this.steps.push(step);
    if (this.steps.length > 12_000) this.steps.splice(0, this.steps.length - 12_000);
  }

  clear() {
    this.steps = [];
    this.sheet.draw();
  }

  get lasted() {
    return this.steps.length ? STEP * (this.steps.at(-1)[0] - this.steps[0][0]) : 0;
  }

  #draw(pen, width, height) {
    const end = STEP * (this.steps.at(-1)?.[0] ?? 0) - this.back;
    const begin = end - this.span;
    const px = (t) => LEFT + ((width - LEFT - 10) * (t - begin)) / this.span;
    const seen = this.steps.filter(([number]) => STEP * number >= begin - STEP && STEP * number <= end + STEP);
    const every = Math.max(1, Math.floor(seen.length / (2 * width)));
    this.rows.forEach((row, k) => this.#row(pen, row, seen, every, { top: 10 + 104 * k, high: 84, width, px }));
    pen.fillStyle = colour("soft");
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const mark of ticks(begin, end, width / 100)) {
      if (mark >= 0) pen.fillText(`${plain(mark, 4)} s`, px(mark), height - 16);
    }
    pen.textAlign = "left";
    pen.strokeStyle = colour("warn");
    pen.lineWidth = 1;
    for (const { time, kind } of this.events) {
      if (time >= begin && time <= end && kind === "mark") line(pen, px(time), 8, px(time), height - 20);
    }
  }

  #row(pen, row, seen, every, { top, high, width, px }) {
    const values = seen.map((step) => step[row.column]).filter((v) => v !== null);
    let [low, most] = [Math.min(...values, row.low ?? Infinity), Math.max(...values, row.high ?? -Infinity)];
    if (!values.length) [low, most] = [0, 1 / row.scale];
    else if (!(most > low)) [low, most] = [(Number.isFinite(low) ? low : 0) - 0.5 / row.scale, (Number.isFinite(most) ? most : 0) + 0.5 / row.scale];
    const py = (v) => top + high * (1 - (v - low) / (most - low));
    pen.lineWidth = 1;
    pen.strokeStyle = colour("line");
    pen.fillStyle = colour("soft");
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const mark of ticks(low * row.scale, most * row.scale, 3)) {
      line(pen, LEFT, py(mark / row.scale), width - 8, py(mark / row.scale));
      pen.fillText(plain(mark), LEFT - 7, py(mark / row.scale));
    }
    pen.save();
    pen.translate(11, top + high / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillText(row.label, 0, 0);
    pen.restore();
    pen.strokeStyle = colour("accent");
    pen.lineWidth = 1.7;
    pen.beginPath();
    let up = true;
    for (let i = 0; i < seen.length; i += every) {
      const value = seen[i][row.column];
      if (value === null) up = true;
      else if (up || (i && seen[i][0] - seen[i - every][0] > 4 * every)) {
        pen.moveTo(px(STEP * seen[i][0]), py(value));
        up = false;
      } else pen.lineTo(px(STEP * seen[i][0]), py(value));
    }
    pen.stroke();
  }
}
