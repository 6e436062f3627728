// What the sensors read: bars, with a mark where the touch that was found would put them.
import { Sheet, line } from "./canvas.js";
import { plain, ticks } from "./numbers.js";
import { colour } from "./theme.js";

const LEFT = 46;

export class Bars {
  constructor(label = "What the sensors read") {
    this.said = null;
    this.sheet = new Sheet(label, (width) => Math.max(170, Math.min(260, 0.46 * width)), (pen, w, h) => this.#draw(pen, w, h));
  }

  // {readings, fitted, noise, names, unit}
  show(said) {
    this.said = said;
    this.sheet.draw();
  }

  #draw(pen, width, height) {
    const said = this.said;
    if (!said) return;
    const { readings, fitted, noise } = said;
    const every = [...readings, ...(fitted ?? []), 0].filter(Number.isFinite);
    let [low, high] = [Math.min(...every), Math.max(...every)];
    const least = 6 * Math.max(...noise, 0);
    if (high - low < least) [low, high] = [low - 0.5 * least, high + 0.5 * least];
    const power = 3 * Math.floor(Math.log10(Math.max(-low, high, 1e-300)) / 3 + 1e-9);
    const scale = 10 ** -power;
    const bottom = height - 24;
    const py = (v) => bottom - ((v - low) / (high - low || 1)) * (bottom - 24);
    pen.fillStyle = colour("soft");
    pen.textBaseline = "alphabetic";
    const ten = power ? `×10${String(power).replace("-", "⁻").replace(/\d/g, (d) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[d])} ` : "";
    pen.fillText(`${ten}${said.unit}`.trim(), 2, 12);
    pen.strokeStyle = colour("line");
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const mark of ticks(low * scale, high * scale, 4)) {
      line(pen, LEFT, py(mark / scale), width - 4, py(mark / scale));
      pen.fillText(plain(mark), LEFT - 7, py(mark / scale));
    }
    const step = (width - LEFT - 8) / readings.length;
    const every_n = Math.ceil(30 / step);
    pen.textAlign = "center";
    readings.forEach((value, i) => {
      const x = LEFT + 4 + step * (i + 0.5);
      pen.fillStyle = colour("soft");
      pen.textBaseline = "top";
      if (i % every_n === 0) pen.fillText(said.names[i], x, bottom + 7);
      if (!Number.isFinite(value)) return;
      pen.fillStyle = colour("accent");
      const wide = Math.max(2, 0.62 * step);
      pen.fillRect(x - 0.5 * wide, Math.min(py(0), py(value)), wide, Math.max(1, Math.abs(py(value) - py(0))));
      if (!fitted) return;
      pen.strokeStyle = colour("found");
      pen.lineWidth = 2.5;
      line(pen, x - 0.45 * step, py(fitted[i]), x + 0.45 * step, py(fitted[i]));
    });
    pen.strokeStyle = colour("edge");
    pen.lineWidth = 1;
    line(pen, LEFT, py(0), width - 4, py(0));
    pen.textAlign = "left";
  }
}
