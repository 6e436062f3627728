// A canvas that is as sharp as the screen, drawn when it is seen and when its size or the theme changes.
import { h } from "./dom.js";
import { colour, onTheme } from "./theme.js";

export class Sheet {
  // height: from the width in CSS pixels.
  constructor(label, height, draw) {
    this.canvas = h("canvas", { role: "img", "aria-label": label });
    this.box = h("div", { class: "drawing" }, this.canvas);
    this.heightOf = height;
    this.paint = draw;
    this.width = 0;
    this.height = 0;
    this.waiting = false;
    new ResizeObserver(() => this.draw()).observe(this.box);
    onTheme(() => this.draw());
  }

  describe(text) {
    this.canvas.setAttribute("aria-label", text);
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.now();
    });
  }

  now() {
    const width = this.box.clientWidth;
    if (!width) return;
    const height = Math.round(this.heightOf(width));
    const sharp = Math.min(window.devicePixelRatio || 1, 3);
    const [wide, high] = [Math.round(width * sharp), Math.round(height * sharp)];
    if (this.canvas.width !== wide || this.canvas.height !== high) {
      this.canvas.width = wide;
      this.canvas.height = high;
      this.canvas.style.height = `${height}px`;
    }
    [this.width, this.height] = [width, height];
    const pen = this.canvas.getContext("2d");
    pen.setTransform(sharp, 0, 0, sharp, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = `${width > 1100 ? 14 : 12}px ${colour("font")}`;
    this.paint(pen, width, height);
  }
}

export function line(pen, x1, y1, x2, y2) {
  pen.beginPath();
  pen.moveTo(x1, y1);
  pen.lineTo(x2, y2);
  pen.stroke();
}

// An arrow that ends at (x, y), of a length and a direction given by its tail.
export function arrow(pen, tailX, tailY, x, y, width, head) {
  const length = Math.hypot(x - tailX, y - tailY);
  if (length < 1) return;
  const [ux, uy] = [(x - tailX) / length, (y - tailY) / length];
  const tip = Math.min(head, 0.7 * length);
  pen.save();
  pen.lineWidth = width;
  pen.lineCap = "round";
  line(pen, tailX, tailY, x - ux * tip, y - uy * tip);
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(x - ux * tip - uy * 0.5 * tip, y - uy * tip + ux * 0.5 * tip);
  pen.lineTo(x - ux * tip + uy * 0.5 * tip, y - uy * tip - ux * 0.5 * tip);
  pen.closePath();
  pen.fill();
  pen.restore();
}
