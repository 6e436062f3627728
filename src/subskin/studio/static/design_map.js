// All designs of one skin, kind and count: depth against pitch, coloured by how near each comes to the goals.
import { Sheet, line } from "./canvas.js";
import { handle } from "./handles.js";
import { clip, plain } from "./numbers.js";
import { colour, isDark } from "./theme.js";

const LEFT = 58;
const FOOT = 72;
const LOW = Math.log(0.2);
const HIGH = Math.log(30);
const LIGHT = [[0, 112, 79], [120, 190, 140], [247, 240, 200], [226, 150, 80], [150, 50, 30]];
const DARK = [[75, 214, 160], [40, 130, 100], [60, 62, 60], [170, 95, 50], [240, 140, 110]];

function shade(ratio) {
  const stops = isDark() ? DARK : LIGHT;
  const met = ratio <= 1; // the middle of the bar is where the goals are met
  const t = met ? 0.5 * clip((Math.log(ratio) - LOW) / -LOW, 0, 1) : 0.5 + 0.5 * clip(Math.log(ratio) / HIGH, 0, 1);
  const at = t * (stops.length - 1);
  const k = Math.min(Math.floor(at), stops.length - 2);
  return `rgb(${stops[k].map((low, c) => Math.round(low + (at - k) * (stops[k + 1][c] - low))).join(" ")})`;
}

export class DesignMap {
  constructor(chosen) {
    this.map = null;
    this.at = [0, 0];
    this.chosen = chosen;
    this.sheet = new Sheet("Depth against pitch, by how near the goals are", (width) => clip(0.6 * width, 240, 480), (pen, w, h) => this.#draw(pen, w, h));
    this.sheet.canvas.addEventListener("click", (event) => this.#click(event));
    let from = null;
    this.handle = handle(this.sheet.box, "cell", "Design on the map", {
      start: () => { from = this.#place(); },
      by: (dx, dy) => this.#near(from[0] + dx, from[1] + dy),
      key: (right, up, coarse) => this.go(this.at[0] + up * coarse * -1, this.at[1] + right * coarse),
      end: () => {},
    });
    this.handle.hide();
  }

  show(map) {
    const kept = this.map ? this.at : null;
    this.map = map;
    this.sheet.draw();
    if (!kept) this.best();
    else this.go(...kept);
  }

  // To the best design.
  best() {
    let [least, at] = [Infinity, [0, 0]];
    this.map.excess.forEach((row, d) => row.forEach((value, s) => {
      if (value !== null && value < least) [least, at] = [value, [d, s]];
    }));
    this.go(...at);
  }

  go(depth, pitch) {
    const { depths, pitches, excess } = this.map;
    this.at = [clip(depth, 0, depths.length - 1), clip(pitch, 0, pitches.length - 1)];
    const [d, s] = this.at;
    this.chosen({ at: this.at, depth: depths[d], pitch: pitches[s], ratio: excess[d][s] });
    requestAnimationFrame(() => this.place());
  }

  place() {
    if (!this.map || !this.sheet.width) return;
    const [d, s] = this.at;
    const ratio = this.map.excess[d][s];
    this.handle.place(...this.#place(), d * 1000 + s, `depth ${plain(1e3 * this.map.depths[d])} mm, pitch ${plain(1e3 * this.map.pitches[s])} mm, ${ratio === null ? "no room" : ratio <= 1 ? "meets the goals" : `${plain(ratio, 2)} times what was wanted${ratio < 30 ? "" : ", or more"}`}`);
  }

  get box() {
    const { width, height } = this.sheet;
    const { depths, pitches } = this.map;
    return { x: LEFT, y: 8, w: (width - LEFT - 10) / pitches.length, h: (height - FOOT - 8) / depths.length };
  }

  #place() {
    const { x, y, w, h } = this.box;
    return [x + (this.at[1] + 0.5) * w, y + (this.at[0] + 0.5) * h];
  }

  #near(px, py) {
    const { x, y, w, h } = this.box;
    this.go(Math.floor((py - y) / h), Math.floor((px - x) / w));
  }

  #click(event) {
    if (!this.map) return;
    const from = this.sheet.canvas.getBoundingClientRect();
    this.#near(event.clientX - from.left, event.clientY - from.top);
  }

  #draw(pen, width, height) {
    if (!this.map) return;
    const { depths, pitches, excess } = this.map;
    const { x, y, w, h } = this.box;
    pen.fillStyle = colour("sunken");
    pen.fillRect(x, y, w * pitches.length, h * depths.length);
    excess.forEach((row, d) => row.forEach((value, s) => {
      if (value === null) return;
      pen.fillStyle = shade(value);
      pen.fillRect(x + s * w, y + d * h, w + 0.5, h + 0.5);
    }));
    pen.strokeStyle = colour("ink");
    pen.lineWidth = 1.4;
    const met = (d, s) => (excess[d]?.[s] ?? Infinity) <= 1;
    excess.forEach((row, d) => row.forEach((_, s) => {
      if (met(d, s) !== met(d, s + 1)) line(pen, x + (s + 1) * w, y + d * h, x + (s + 1) * w, y + (d + 1) * h);
      if (met(d, s) !== met(d + 1, s)) line(pen, x + s * w, y + (d + 1) * h, x + (s + 1) * w, y + (d + 1) * h);
    }));
    pen.fillStyle = colour("soft");
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    const every = (count, room, size) => Math.ceil((count * size) / Math.max(room, 1));
    depths.forEach((depth, d) => d % every(depths.length, h * depths.length, 16) === 0 && pen.fillText(plain(1e3 * depth, 2), x - 7, y + (d + 0.5) * h));
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const foot = y + h * depths.length;
    pitches.forEach((pitch, s) => s % every(pitches.length, w * pitches.length, 34) === 0 && pen.fillText(plain(1e3 * pitch, 2), x + (s + 0.5) * w, foot + 5));
    pen.fillText("pitch of sensors [mm]", x + (w * pitches.length) / 2, foot + 22);
    pen.save();
    pen.translate(11, y + (h * depths.length) / 2);
    pen.rotate(-Math.PI / 2);
    pen.fillText("depth [mm]", 0, -6);
    pen.restore();
    this.#bar(pen, x, height - 24, w * pitches.length);
    this.place();
  }

  #bar(pen, x, y, width) {
    for (let i = 0; i < width; i += 1) {
      const t = i / width;
      pen.fillStyle = shade(Math.exp(t < 0.5 ? LOW * (1 - 2 * t) : HIGH * (2 * t - 1)));
      pen.fillRect(x + i, y, 1.5, 7);
    }
    pen.fillStyle = colour("soft");
    pen.textBaseline = "top";
    [[0, "0.2", "left"], [0.5, "1: met", "center"], [1, "30 times too large", "right"]].forEach(([t, text, align]) => {
      pen.textAlign = align;
      pen.fillText(text, x + t * width, y + 8);
    });
    pen.textAlign = "left";
  }
}
