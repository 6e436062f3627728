// Curves on axes, with marks: the figures of the memo and the searches.
import { Sheet, line } from "./canvas.js";
import { clip, plain, ticks } from "./numbers.js";
import { colour } from "./theme.js";

const LEFT = 62;
const FOOT = 44;
const INK = { right: "accent", printed: "found", 1: "accent", 2: "found", 3: "good", 4: "rival", good: "good", bad: "bad" };
const DASH = { printed: [7, 5], 3: [7, 4], 4: [2, 3] };

export const inkOf = (kind) => colour(INK[kind] ?? "ink");

export class Plot {
  constructor(label) {
    this.panel = null;
    this.sheet = new Sheet(label, (width) => clip(0.56 * width, 210, 460), (pen, w, h) => this.#draw(pen, w, h));
  }

  show(panel) {
    this.panel = panel;
    this.sheet.describe(`${panel.title}: ${panel.curves.map((one) => one.label).join(", ")} against ${panel.xlabel}`);
    this.sheet.draw();
  }

  #draw(pen, width, height) {
    const { panel } = this;
    if (!panel) return;
    const xs = panel.curves.flatMap((one) => [one.x[0], one.x.at(-1)]);
    const [left, right] = [Math.min(...xs), Math.max(...xs)];
    const ys = panel.curves.flatMap((one) => one.y.filter((v) => v !== null));
    let [low, high] = [panel.low ?? Math.min(...ys, 0), panel.high ?? Math.max(...ys, 0)];
    if (panel.low === undefined) low -= 0.06 * (high - low);
    if (panel.high === undefined) high += 0.06 * (high - low);
    if (!(high > low)) high = low + 1;
    const box = { x: LEFT, y: 10, w: width - LEFT - 12, h: height - FOOT - 10 };
    const px = (v) => box.x + (box.w * (v - left)) / (right - left || 1);
    const py = (v) => box.y + box.h * (1 - (v - low) / (high - low));
    this.#axes(pen, box, [left, right, low, high], px, py);
    pen.save();
    pen.beginPath();
    pen.rect(box.x - 6, box.y - 2, box.w + 12, box.h + 4);
    pen.clip();
    for (const one of panel.curves) {
      pen.strokeStyle = inkOf(one.kind);
      pen.setLineDash(DASH[one.kind] ?? []);
      pen.lineWidth = 2;
      pen.beginPath();
      let up = true;
      one.x.forEach((x, i) => {
        if (one.y[i] === null) {
          up = true;
          return;
        }
        const y = clip(py(one.y[i]), -1e4, 1e4);
        if (up) pen.moveTo(px(x), y);
        else pen.lineTo(px(x), y);
        up = false;
      });
      pen.stroke();
    }
    pen.setLineDash([]);
    for (const one of panel.marks) {
      pen.beginPath();
      pen.arc(px(one.x), py(one.y), 5, 0, 2 * Math.PI);
      pen.fillStyle = colour("card");
      pen.strokeStyle = inkOf(one.kind);
      pen.lineWidth = 2.2;
      pen.fill();
      pen.stroke();
    }
    pen.restore();
  }

  #axes(pen, box, [left, right, low, high], px, py) {
    const { panel } = this;
    pen.strokeStyle = colour("line");
    pen.fillStyle = colour("soft");
    pen.lineWidth = 1;
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const bottom = box.y + box.h;
    for (const mark of ticks(left, right, box.w / 80)) {
      line(pen, px(mark), box.y, px(mark), bottom);
      pen.fillText(plain(mark), px(mark), bottom + 5);
    }
    pen.fillText(panel.xlabel, box.x + box.w / 2, bottom + 24);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const mark of ticks(low, high, box.h / 45)) {
      line(pen, box.x, py(mark), box.x + box.w, py(mark));
      pen.fillText(plain(mark), box.x - 7, py(mark));
    }
    pen.save();
    pen.translate(11, box.y + box.h / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillText(panel.ylabel, 0, 0);
    pen.restore();
    pen.textAlign = "left";
    pen.strokeStyle = colour("edge");
    if (low < 0 && high > 0) line(pen, box.x, py(0), box.x + box.w, py(0));
    line(pen, box.x, bottom, box.x + box.w, bottom);
  }
}
