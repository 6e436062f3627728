// The skin from above: the field at the depth of the sensors, the sensors, where it presses and drags.
import { Sheet, arrow, line } from "./canvas.js";
import { drawField } from "./field.js";
import { clip, plain, ticks } from "./numbers.js";
import { colour } from "./theme.js";

const LEFT = 46;
const FOOT = 26;

export class Above {
  constructor() {
    this.said = null;
    this.sheet = new Sheet("The skin from above", (width) => this.#height(width), (pen, width) => this.#draw(pen, width));
  }

  show(said) {
    this.said = said;
    this.sheet.draw();
  }

  #height(width) {
    if (!this.said) return width;
    const { left, right, front, back } = this.said.window;
    return ((width - LEFT - 10) * (back - front)) / (right - left) + FOOT + 8;
  }

  // z grows upwards on the page.
  get scale() {
    const { left, right, front, back } = this.said.window;
    const k = (this.sheet.width - LEFT - 10) / (right - left);
    return { k, px: (y) => LEFT + k * (y - left), py: (z) => 8 + k * (back - z), high: k * (back - front) };
  }

  // The drag, as an arrow on the skin.
  drag(components) {
    const size = Math.hypot(...components);
    return (0.2 * this.scale.high) / Math.max(size, 1e-300);
  }

  #draw(pen, width) {
    const said = this.said;
    const field = said?.fields.find((one) => one.name === "above");
    if (!field) return;
    const { px, py, k, high } = this.scale;
    const { left, right, front, back } = said.window;
    drawField(pen, field, px, py, [px(left), py(back), px(right) - px(left), high]);
    pen.strokeStyle = colour("edge");
    pen.lineWidth = 1;
    pen.strokeRect(px(left), py(back), px(right) - px(left), high);
    pen.fillStyle = colour("soft");
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const marks = ticks(1e3 * left, 1e3 * right, width / 90);
    for (const mark of marks) {
      line(pen, px(mark / 1e3), py(front), px(mark / 1e3), py(front) + 4);
      pen.fillText(plain(mark) + (mark === marks.at(-1) ? " mm" : ""), px(mark / 1e3), py(front) + 7);
    }
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const mark of ticks(1e3 * front, 1e3 * back, high / 60)) {
      line(pen, px(left) - 4, py(mark / 1e3), px(left), py(mark / 1e3));
      pen.fillText(plain(mark), px(left) - 7, py(mark / 1e3));
    }
    pen.textAlign = "left";
    this.#cut(pen);
    this.#sensors(pen);
    const { touch } = said.state;
    if (said.wide) {
      pen.beginPath();
      pen.arc(px(touch.position[0]), py(touch.position[1]), k * touch.half_width, 0, 2 * Math.PI);
      pen.strokeStyle = colour("truth");
      pen.lineWidth = 1.6;
      pen.stroke();
    }
    const t = touch.force * Math.sin(touch.angle);
    const parts = [touch.force * Math.cos(touch.angle), t * Math.cos(touch.azimuth), t * Math.sin(touch.azimuth)];
    this.#load(pen, touch.position, parts, "truth", 3.5);
    if (said.found.load) this.#load(pen, said.found.load.position, said.found.load.components, "found", 2.2);
  }

  #cut(pen) {
    const { px, py } = this.scale;
    const { left, right } = this.said.window;
    const z = this.said.state.touch.position[1];
    pen.save();
    pen.setLineDash([5, 4]);
    pen.strokeStyle = colour("soft");
    pen.lineWidth = 1;
    line(pen, px(left), py(z), px(right), py(z));
    pen.restore();
  }

  #sensors(pen) {
    const { px, py } = this.scale;
    const { y, z, live } = this.said.sensors;
    const size = clip(this.sheet.width / 110, 3, 7);
    y.forEach((at, i) => {
      pen.beginPath();
      pen.arc(px(at), py(z[i]), size, 0, 2 * Math.PI);
      pen.fillStyle = live[i] ? colour("card") : colour("bad");
      pen.strokeStyle = colour("ink");
      pen.lineWidth = 1.4;
      pen.fill();
      pen.stroke();
    });
  }

  #load(pen, at, components, name, width) {
    const { px, py } = this.scale;
    const k = this.drag(components);
    pen.strokeStyle = pen.fillStyle = colour(name);
    const [x, y] = [px(at[0]), py(at[1])];
    arrow(pen, x, y, x + k * components[1], y - k * components[2], width, 11);
    pen.beginPath();
    pen.arc(x, y, width + 0.5, 0, 2 * Math.PI);
    pen.fill();
  }
}
