// The skin cut open, to scale: the field, the sensors, the touch, and the touch found again.
import { Sheet, arrow, line } from "./canvas.js";
import { drawBar, drawField } from "./field.js";
import { clip, plain, ticks } from "./numbers.js";
import { colour } from "./theme.js";

const TOP = 0.19; // room above the skin, in widths of what is seen
const REACH = 0.88; // of that room, an arrow takes at most so much
const LEFT = 46;
const NARROW = 560; // below, the colour bar has its label above it

export class Section {
  constructor() {
    this.said = null;
    this.sheet = new Sheet("The skin in section", (width) => this.#height(width), (pen, width) => this.#draw(pen, width));
  }

  show(said) {
    this.said = said;
    this.sheet.draw();
  }

  #height(width) {
    if (!this.said) return 0.5 * width;
    const { left, right } = this.said.window;
    return ((width - LEFT - 10) / (right - left)) * (this.#foot() + TOP * (right - left)) + (width < NARROW ? 90 : 74);
  }

  #foot() {
    const { bottom } = this.said.window;
    const { base } = this.said.skin;
    return base !== null && base <= bottom * 1.001 ? bottom * 1.1 : bottom;
  }

  // From metres to pixels; depth grows downwards.
  get scale() {
    const { left, right } = this.said.window;
    const k = (this.sheet.width - LEFT - 10) / (right - left);
    const top = TOP * (right - left) * k;
    return { k, top, px: (y) => LEFT + k * (y - left), py: (x) => top + k * x };
  }

  // The arrow of a force: its length says how large it is, and never leaves the room above the skin.
  length(force) {
    return REACH * this.scale.top * (force / (force + 0.7 * this.said.usual));
  }

  force(length) {
    const share = clip(length / (REACH * this.scale.top), 0.02, 0.97);
    return (share / (1 - share)) * 0.7 * this.said.usual;
  }

  #draw(pen, width) {
    const said = this.said;
    if (!said) return;
    const { px, py, top, k } = this.scale;
    const { left, right, bottom } = said.window;
    const field = said.fields.find((one) => one.name === "section");
    const foot = this.#foot();
    pen.fillStyle = colour("skin");
    pen.fillRect(px(left), top, px(right) - px(left), k * bottom);
    drawField(pen, field, px, py, [px(left), top, px(right) - px(left), k * bottom]);
    this.#inside(pen, foot);
    this.#axes(pen, width, foot);
    this.#sensors(pen);
    this.#touch(pen);
    this.#found(pen);
    const y = py(foot) + 30;
    pen.fillStyle = colour("soft");
    pen.textBaseline = "top";
    const label = `${field.label} [${field.unit}]`;
    const narrow = width < NARROW;
    const taken = narrow ? 0 : Math.max(pen.measureText(label).width + 14, 0.2 * width);
    pen.fillText(label, px(left), y - 1);
    drawBar(pen, field, px(left) + taken, y + (narrow ? 17 : 0), px(right) - px(left) - taken, 12);
  }

  #inside(pen, foot) {
    const { px, py } = this.scale;
    const { left, right, bottom } = this.said.window;
    pen.strokeStyle = colour("ink");
    if (foot > bottom) {
      pen.fillStyle = colour("base");
      pen.fillRect(px(left), py(bottom), px(right) - px(left), py(foot) - py(bottom));
      pen.lineWidth = 1.2;
      line(pen, px(left), py(bottom), px(right), py(bottom));
    }
    pen.save();
    pen.setLineDash([6, 4]);
    pen.lineWidth = 1;
    for (const depth of this.said.skin.interfaces) {
      if (depth < bottom) line(pen, px(left), py(depth), px(right), py(depth));
    }
    pen.restore();
    pen.lineWidth = 1.6;
    line(pen, px(left), py(0), px(right), py(0));
  }

  #axes(pen, width, foot) {
    const { px, py } = this.scale;
    const { left, right, bottom } = this.said.window;
    pen.fillStyle = colour("soft");
    pen.strokeStyle = colour("edge");
    pen.lineWidth = 1;
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const marks = ticks(1e3 * left, 1e3 * right, width / 65);
    const arc = this.said.skin.curved ? ", unrolled" : "";
    for (const mark of marks) {
      line(pen, px(mark / 1e3), py(foot), px(mark / 1e3), py(foot) + 4);
      const unit = mark === marks.at(-1) ? ` mm${width > 560 ? arc : ""}` : "";
      pen.fillText(plain(mark) + unit, px(mark / 1e3), py(foot) + 7);
    }
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const mark of ticks(0, 1e3 * bottom, Math.max(2, (py(bottom) - py(0)) / 45))) {
      line(pen, px(left) - 4, py(mark / 1e3), px(left), py(mark / 1e3));
      pen.fillText(plain(mark), px(left) - 7, py(mark / 1e3));
    }
    pen.textAlign = "left";
  }

  #sensors(pen) {
    const { px, py } = this.scale;
    const { y, depth, live } = this.said.sensors;
    const size = clip(this.sheet.width / 170, 3.5, 8);
    y.forEach((at, i) => {
      pen.beginPath();
      pen.arc(px(at), py(depth[i]), size, 0, 2 * Math.PI);
      pen.fillStyle = live[i] ? colour("card") : colour("bad");
      pen.strokeStyle = colour("ink");
      pen.lineWidth = 1.5;
      pen.fill();
      pen.stroke();
    });
  }

  // Where the touch is found to be: its arrow, and a bar of 95 %.
  #found(pen) {
    const load = this.said.found.load;
    if (!load) return;
    const { px, py } = this.scale;
    const [normal, drag] = load.components;
    const size = Math.hypot(normal, drag);
    const length = this.length(size);
    const x = px(load.position[0]);
    pen.save();
    pen.strokeStyle = pen.fillStyle = colour("found");
    pen.globalAlpha = 0.95;
    arrow(pen, x - (length * drag) / size, py(0) - (length * normal) / size, x, py(0), 2.5, 12);
    const half = 1.96 * load.std[0] * this.scale.k;
    pen.lineWidth = 4;
    line(pen, x - Math.max(half, 1), py(0) + 3, x + Math.max(half, 1), py(0) + 3);
    const rival = this.said.found.rival;
    if (rival && rival.worse < 40) {
      pen.setLineDash([3, 3]);
      pen.strokeStyle = pen.fillStyle = colour("rival");
      const [n, t] = rival.components;
      const long = this.length(Math.hypot(n, t));
      const at = px(rival.position[0]);
      arrow(pen, at - (long * t) / Math.hypot(n, t), py(0) - (long * n) / Math.hypot(n, t), at, py(0), 2, 10);
    }
    pen.restore();
  }

  #touch(pen) {
    const { px, py, top } = this.scale;
    const { touch } = this.said.state;
    const pressure = this.said.pressure;
    if (pressure) {
      pen.beginPath();
      pen.moveTo(px(pressure.y[0]), py(0));
      pressure.y.forEach((y, i) => pen.lineTo(px(y), py(0) - 0.3 * top * pressure.share[i]));
      pen.lineTo(px(pressure.y.at(-1)), py(0));
      pen.closePath();
      pen.fillStyle = colour("edge");
      pen.save();
      pen.globalAlpha = 0.45;
      pen.fill();
      pen.restore();
    }
    const lean = this.lean();
    const length = this.length(touch.force);
    pen.strokeStyle = pen.fillStyle = colour("truth");
    const x = px(touch.position[0]);
    arrow(pen, x - length * Math.sin(lean), py(0) - length * Math.cos(lean), x, py(0), 4.5, 16);
  }

  // The angle as it is seen in the section.
  lean() {
    const { touch } = this.said.state;
    if (touch.position.length === 1) return touch.angle;
    return Math.atan2(Math.sin(touch.angle) * Math.cos(touch.azimuth), Math.cos(touch.angle));
  }
}
