// Numbers as people read them.
export function plain(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const rounded = Number(value.toPrecision(digits));
  return String(Math.abs(rounded) < 1e-12 ? 0 : rounded).replace("-", "−");
}

// Round values between low and high, about as many as asked for; two at least, for one says nothing of the scale.
export function ticks(low, high, about) {
  const rough = (high - low) / Math.max(about, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((m) => m * power >= rough * 0.999);
  const out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) out.push(k * step);
  if (out.length < 2 && high > low) return ticks(low, high, 2 * Math.max(about, 1));
  return out.map((value) => Number(value.toPrecision(12)));
}

export const degrees = 180 / Math.PI;
export const clip = (value, low, high) => Math.min(Math.max(value, low), high);
