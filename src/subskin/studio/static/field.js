// A field of bytes as a picture on the skin, and the colour bar that says what its colours mean.
import { css, table } from "./colours.js";
import { colour, isDark } from "./theme.js";
import { plain } from "./numbers.js";
import { line } from "./canvas.js";

const pictures = new WeakMap();

function picture(field) {
  const dark = isDark();
  const kept = pictures.get(field);
  if (kept && kept.dark === dark) return kept.canvas;
  const [rows, columns] = field.shape;
  const canvas = document.createElement("canvas");
  canvas.width = columns;
  canvas.height = rows;
  const pen = canvas.getContext("2d");
  const image = pen.createImageData(columns, rows);
  const colours = table();
  const pixels = new Uint32Array(image.data.buffer);
  for (let i = 0; i < pixels.length; i += 1) pixels[i] = colours[field.bytes[i]];
  pen.putImageData(image, 0, 0);
  pictures.set(field, { dark, canvas });
  return canvas;
}

// px, py: from metres to pixels. The box keeps what is drawn in the skin.
export function drawField(pen, field, px, py, box) {
  const [x, width] = field.x;
  const [y, height] = field.y;
  pen.save();
  pen.beginPath();
  pen.rect(...box);
  pen.clip();
  pen.imageSmoothingEnabled = true;
  pen.imageSmoothingQuality = "high";
  pen.translate(px(x), py(y));
  pen.scale((px(x + width) - px(x)) / field.shape[1], (py(y + height) - py(y)) / field.shape[0]); // turned over where the axis goes up
  pen.drawImage(picture(field), 0, 0);
  pen.restore();
}

// The same squeezing as the server's: linear near zero, logarithmic beyond.
const share = (value, field) => Math.asinh((field.range * value) / field.most) / Math.asinh(field.range);

export function drawBar(pen, field, x, y, width, height) {
  for (let i = 0; i < width; i += 1) {
    pen.fillStyle = css(Math.round((255 * i) / Math.max(width - 1, 1)));
    pen.fillRect(x + i, y, 1.5, height);
  }
  pen.strokeStyle = colour("edge");
  pen.lineWidth = 1;
  pen.strokeRect(x + 0.5, y + 0.5, width - 1, height - 1);
  pen.fillStyle = colour("soft");
  pen.textBaseline = "top";
  const size = Number.parseFloat(pen.font);
  const values = [0, 1, -1, 0.3, -0.3, 0.1, -0.1, 0.03, -0.03];
  const taken = [];
  for (const part of values) {
    const at = x + 0.5 * width * (1 + share(part * field.most, field));
    const text = plain(part * field.most, 2);
    const half = 0.5 * pen.measureText(text).width + 5;
    if (taken.some(([low, high]) => at - half < high && at + half > low)) continue;
    taken.push([at - half, at + half]);
    line(pen, at, y + height, at, y + height + 4);
    pen.textAlign = part === 1 ? "right" : part === -1 ? "left" : "center";
    pen.fillText(text, part === 1 ? x + width : part === -1 ? x : at, y + height + 6);
  }
  pen.textAlign = "left";
  return size + 10 + height;
}
