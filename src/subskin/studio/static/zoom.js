// The estimate from so near that its errors are seen: the ellipses of 68 and 95 %, the truth, and the rival.
import { Sheet, line } from "./canvas.js";
import { plain, ticks } from "./numbers.js";
import { colour } from "./theme.js";

const LEFT = 58;
const FOOT = 40;
const RINGS = [Math.sqrt(2.2957), Math.sqrt(5.9915)]; // chi-square of two unknowns: 68.27 and 95 %

export class Zoom {
  constructor() {
    this.said = null;
    this.sheet = new Sheet("The estimate and its errors", (width) => Math.max(200, Math.min(300, 0.62 * width)), (pen, w, h) => this.#draw(pen, w, h));
  }

  show(said) {
    this.said = said;
    this.sheet.draw();
  }

  #draw(pen, width, height) {
    const said = this.said;
    pen.textBaseline = "middle";
    if (!said) {
      pen.fillStyle = colour("soft");
      pen.fillText("There is no estimate to draw.", 4, height / 2);
      return;
    }
    const { centre, covariance, truth, rival, axes } = said;
    const std = [0, 1].map((i) => Math.sqrt(Math.max(covariance[i][i], 0)) || 1e-12);
    const reach = [0, 1].map((i) => Math.max(3.4 * std[i], Math.min(1.25 * Math.abs(truth[i] - centre[i]), 12 * std[i])));
    const box = { x: LEFT, y: 8, width: width - LEFT - 12, height: height - FOOT - 8 };
    const px = (v) => box.x + box.width * (0.5 + (0.5 * (v - centre[0])) / reach[0]);
    const py = (v) => box.y + box.height * (0.5 - (0.5 * (v - centre[1])) / reach[1]);
    this.#axes(pen, box, centre, reach, axes, px, py);
    pen.save();
    pen.beginPath();
    pen.rect(box.x, box.y, box.width, box.height);
    pen.clip();
    for (const [k, ring] of [...RINGS.entries()].reverse()) {
      pen.beginPath();
      const [a, b, c] = factor(covariance);
      for (let t = 0; t <= 64; t += 1) {
        const [u, v] = [ring * Math.cos((t * Math.PI) / 32), ring * Math.sin((t * Math.PI) / 32)];
        const [x, y] = [px(centre[0] + a * u), py(centre[1] + b * u + c * v)];
        if (t) pen.lineTo(x, y);
        else pen.moveTo(x, y);
      }
      pen.fillStyle = pen.strokeStyle = colour("found");
      pen.globalAlpha = k ? 0.14 : 0.26;
      pen.fill();
      pen.globalAlpha = 0.9;
      pen.lineWidth = 1.4;
      pen.stroke();
    }
    pen.globalAlpha = 1;
    pen.fillStyle = colour("found");
    pen.beginPath();
    pen.arc(px(centre[0]), py(centre[1]), 4, 0, 2 * Math.PI);
    pen.fill();
    pen.strokeStyle = colour("truth");
    pen.lineWidth = 2.4;
    cross(pen, px(truth[0]), py(truth[1]), 7);
    if (rival) {
      pen.strokeStyle = colour("rival");
      cross(pen, px(rival[0]), py(rival[1]), 6);
    }
    pen.restore();
  }

  #axes(pen, box, centre, reach, axes, px, py) {
    pen.strokeStyle = colour("line");
    pen.fillStyle = colour("soft");
    pen.lineWidth = 1;
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const bottom = box.y + box.height;
    const span = (i) => [axes[i].scale * (centre[i] - reach[i]), axes[i].scale * (centre[i] + reach[i])];
    for (const mark of ticks(...span(0), box.width / 90)) {
      line(pen, px(mark / axes[0].scale), box.y, px(mark / axes[0].scale), bottom);
      pen.fillText(plain(mark, 5), px(mark / axes[0].scale), bottom + 5);
    }
    pen.fillText(`${axes[0].label} [${axes[0].unit}]`, box.x + box.width / 2, bottom + 22);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const mark of ticks(...span(1), box.height / 45)) {
      line(pen, box.x, py(mark / axes[1].scale), box.x + box.width, py(mark / axes[1].scale));
      pen.fillText(plain(mark, 5), box.x - 6, py(mark / axes[1].scale));
    }
    pen.save();
    pen.translate(11, box.y + box.height / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillText(`${axes[1].label} [${axes[1].unit}]`, 0, 0);
    pen.restore();
    pen.textAlign = "left";
    pen.strokeStyle = colour("edge");
    pen.strokeRect(box.x, box.y, box.width, box.height);
  }
}

function cross(pen, x, y, size) {
  line(pen, x - size, y - size, x + size, y + size);
  line(pen, x - size, y + size, x + size, y - size);
}

// The lower triangle whose square is the covariance.
function factor([[p, q], [, r]]) {
  const a = Math.sqrt(Math.max(p, 1e-300));
  const b = q / a;
  return [a, b, Math.sqrt(Math.max(r - b * b, 0))];
}
