// What touches now: bars over a row of sensors or discs on an area, the force as an arrow, and where it was.
import { Sheet, arrow, line } from "./canvas.js";
import { css } from "./colours.js";
import { clip, plain, ticks } from "./numbers.js";
import { colour } from "./theme.js";

const LEFT = 46;

export class LiveMap {
  constructor() {
    this.about = null;
    this.now = null;
    this.full = 20;
    this.most = 1e-9;
    this.sheet = new Sheet("What touches now", (width) => this.#height(width), (pen, w, h) => this.#draw(pen, w, h));
  }

  begin(about) {
    this.about = about;
    [this.full, this.most] = [20, 1e-9];
    this.sheet.draw();
  }

  show(now) {
    this.now = now;
    const strength = now.strength?.filter(Number.isFinite).map(Math.abs) ?? [];
    this.full = Math.max(0.995 * this.full, 1.1 * Math.max(...strength, 0), 20);
    if (now.load) this.most = Math.max(0.998 * this.most, Math.hypot(...now.load.components));
    this.sheet.draw();
  }

  get window() {
    const { sensors } = this.about;
    const depth = Math.max(...sensors.depth);
    const ends = (values) => [Math.min(...values) - 2 * depth, Math.max(...values) + 2 * depth];
    return { y: ends(sensors.y), z: ends(sensors.z) };
  }

  #height(width) {
    if (!this.about?.area) return clip(0.42 * width, 190, 420);
    const { y, z } = this.window;
    return clip(((width - LEFT - 10) * (z[1] - z[0])) / (y[1] - y[0]), 160, 620) + 30;
  }

  #draw(pen, width, height) {
    if (!this.about) return;
    if (this.about.area) this.#area(pen, width, height);
    else this.#row(pen, width, height);
  }

  #row(pen, width, height) {
    const { y } = this.window;
    const { sensors, names } = { sensors: this.about.sensors, names: this.about.sensors.names };
    const px = (v) => LEFT + ((width - LEFT - 12) * (v - y[0])) / (y[1] - y[0]);
    const skin = 0.44 * height;
    const zero = skin + 0.5 * (height - 26 - skin);
    pen.fillStyle = colour("skin");
    pen.fillRect(px(y[0]), skin, px(y[1]) - px(y[0]), height - 26 - skin);
    pen.strokeStyle = colour("ink");
    pen.lineWidth = 1.6;
    line(pen, px(y[0]), skin, px(y[1]), skin);
    pen.strokeStyle = colour("edge");
    pen.lineWidth = 1;
    line(pen, px(y[0]), zero, px(y[1]), zero);
    const step = sensors.y.length > 1 ? (px(sensors.y.at(-1)) - px(sensors.y[0])) / (sensors.y.length - 1) : 40;
    const wide = clip(0.6 * Math.abs(step), 3, 60);
    sensors.y.forEach((at, i) => {
      const value = this.now?.strength?.[i];
      if (value === null || value === undefined) return;
      const high = (clip(value / this.full, -1, 1)) * (zero - skin - 6);
      pen.fillStyle = colour("accent");
      pen.fillRect(px(at) - wide / 2, Math.min(zero, zero - high), wide, Math.max(1, Math.abs(high)));
    });
    pen.fillStyle = colour("soft");
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const every = Math.ceil(34 / Math.max(Math.abs(step), 1));
    sensors.y.forEach((at, i) => i % every === 0 && pen.fillText(names[i], px(at), height - 21));
    pen.textAlign = "left";
    pen.fillText("in noises of each sensor", 4, 3);
    this.#trail(pen, px, () => skin + 3);
    const load = this.now?.load;
    if (!load) return;
    const [n, t] = load.components;
    const size = Math.hypot(n, t);
    const long = (0.9 * skin * size) / Math.max(this.most, size);
    pen.strokeStyle = pen.fillStyle = colour("found");
    const x = px(load.position[0]);
    arrow(pen, x - (long * t) / size, skin - (long * n) / size, x, skin, 4, 15);
  }

  #area(pen, width, height) {
    const { y, z } = this.window;
    const { sensors } = this.about;
    const k = Math.min((width - LEFT - 10) / (y[1] - y[0]), (height - 30) / (z[1] - z[0]));
    const px = (v) => LEFT + k * (v - y[0]);
    const pz = (v) => 6 + k * (z[1] - v);
    pen.fillStyle = colour("skin");
    pen.fillRect(px(y[0]), pz(z[1]), px(y[1]) - px(y[0]), pz(z[0]) - pz(z[1]));
    const apart = nearest(sensors);
    sensors.y.forEach((at, i) => {
      const value = this.now?.strength?.[i] ?? 0;
      pen.beginPath();
      pen.arc(px(at), pz(sensors.z[i]), clip(0.46 * k * apart, 4, 60), 0, 2 * Math.PI);
      pen.fillStyle = css(Math.round(127.5 + 127.5 * clip(Math.asinh((8 * value) / this.full) / Math.asinh(8), -1, 1)));
      pen.fill();
      pen.strokeStyle = colour("edge");
      pen.lineWidth = 1;
      pen.stroke();
    });
    pen.fillStyle = colour("soft");
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const marks = ticks(1e3 * y[0], 1e3 * y[1], width / 90);
    for (const mark of marks) pen.fillText(plain(mark) + (mark === marks.at(-1) ? " mm" : ""), px(mark / 1e3), pz(z[0]) + 6);
    pen.textAlign = "left";
    this.#trail(pen, px, pz);
    const load = this.now?.load;
    if (!load) return;
    const [x, top] = [px(load.position[0]), pz(load.position[1])];
    const scale = (0.28 * (pz(z[0]) - pz(z[1]))) / Math.max(this.most, 1e-12);
    pen.strokeStyle = pen.fillStyle = colour("found");
    pen.lineWidth = 2.5;
    pen.beginPath();
    pen.arc(x, top, Math.max(4, 0.5 * scale * load.components[0]), 0, 2 * Math.PI);
    pen.stroke();
    arrow(pen, x, top, x + scale * load.components[1], top - scale * load.components[2], 3.5, 12);
  }

  #trail(pen, px, py) {
    const trail = this.now?.trail ?? [];
    pen.fillStyle = colour("found");
    trail.forEach(([y, z, force], i) => {
      if (!(force > 0) || y === null) return;
      pen.globalAlpha = 0.08 + (0.5 * i) / trail.length;
      pen.beginPath();
      pen.arc(px(y), py(z ?? 0), 3, 0, 2 * Math.PI);
      pen.fill();
    });
    pen.globalAlpha = 1;
  }
}

function nearest({ y, z }) {
  let best = Infinity;
  for (let i = 1; i < y.length; i += 1) {
    const apart = Math.hypot(y[i] - y[0], z[i] - z[0]);
    if (apart > 1e-9) best = Math.min(best, apart);
  }
  return Number.isFinite(best) ? best : 2e-3;
}
