// How people read quantities: the log is in SI, a screen in millimetres and kilopascals.

const SHOWN = {
  m: [1e3, "mm"], "m/s": [1e3, "mm/s"], "m/s^2": [1, "m/s²"], Pa: [1e-3, "kPa"],
  rad: [180 / Math.PI, "°"], "rad/s": [180 / Math.PI, "°/s"], s: [1e3, "ms"], 1: [1, ""],
};
const LONG = new Set(["clock", "reference.time", "reading.marker_time"]);

export function shown(column) {
  if (LONG.has(column[0])) return [1, column[1]];
  return SHOWN[column[1]] ?? [1, column[1]];
}

export function number(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(2).replaceAll("-", "−");
  const places = size < 1e-9 ? 2 : Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return value.toFixed(Math.min(places, 4)).replace("-", "−");
}

export function seconds(t) {
  return `${number(t, t < 100 ? 4 : 5)} s`;
}

function multiples(low, high, step) {
  const found = [];
  const last = high + 1e-9 * (high - low);
  for (let k = Math.ceil(low / step - 1e-9); k * step <= last; k += 1) found.push(k * step);
  return found;
}

// Round steps of an axis that lie between two values.
export function ticks(low, high, most) {
  const span = high - low;
  if (!(span > 0)) return [low];
  const raw = span / Math.max(most, 1);
  const power = 10 ** Math.floor(Math.log10(raw));
  const wide = [1, 2, 5, 10].find((factor) => factor * power >= raw * 0.999);
  const found = multiples(low, high, wide * power);
  // A single step tells no scale.
  return found.length > 1 ? found : multiples(low, high, (wide === 5 ? 2 : wide / 2) * power);
}

// A step of an axis with as many places as its neighbours need.
export function tick(value, all) {
  const step = all.length > 1 ? all[1] - all[0] : Math.abs(value) || 1;
  const places = Math.min(Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), 6);
  return value.toFixed(places).replace("-", "−");
}
