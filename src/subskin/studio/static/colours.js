// The colours of a field: red where it is above zero, blue below, as in the figures of the library.
import { isDark } from "./theme.js";

const LIGHT = [[5, 48, 97], [33, 102, 172], [67, 147, 195], [146, 197, 222], [209, 229, 240], [247, 247, 247],
  [253, 219, 199], [244, 165, 130], [214, 96, 77], [178, 24, 43], [103, 0, 31]];
const DARK = [[158, 202, 255], [96, 165, 250], [52, 122, 214], [32, 82, 150], [26, 50, 88], [24, 28, 35],
  [84, 40, 34], [146, 58, 40], [212, 88, 50], [247, 138, 84], [255, 196, 150]];
const made = new Map();

export function table() {
  const dark = isDark();
  if (!made.has(dark)) {
    const stops = dark ? DARK : LIGHT;
    const out = new Uint32Array(256);
    for (let i = 0; i < 256; i += 1) {
      const at = (i / 255) * (stops.length - 1);
      const k = Math.min(Math.floor(at), stops.length - 2);
      const [r, g, b] = stops[k].map((low, c) => Math.round(low + (at - k) * (stops[k + 1][c] - low)));
      out[i] = (255 << 24) | (b << 16) | (g << 8) | r; // little-endian, as canvases are here
    }
    made.set(dark, out);
  }
  return made.get(dark);
}

export const css = (index) => {
  const value = table()[index];
  return `rgb(${value & 255} ${(value >> 8) & 255} ${(value >> 16) & 255})`;
};
