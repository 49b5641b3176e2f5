// The traces of a pane: how far they go, and each as a line.

import { color } from "./look.js";
import { PLANNED } from "./names.js";
import { shown } from "./units.js";

// From the least to the greatest of what is shown, with some room.
export function range(board, seen, table, first, last) {
  let [low, high] = [Infinity, -Infinity];
  for (const k of seen) {
    const column = table.values[table.place.get(k)];
    if (!column) continue;
    const scale = shown(board.columns[k])[0];
    for (let row = first; row < last; row += 1) {
      const value = column[row] * scale;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (low > high) return [-1, 1];
  const room = Math.max(0.07 * (high - low), 1e-3 * Math.max(Math.abs(low), Math.abs(high)), 1e-9);
  return [low - room, high + room];
}

// Where there are more rows than pixels, each pixel gets the least and the greatest of its rows.
export function trace(context, table, { k, channel, ink }, first, last, x, y, width = null) {
  const column = table.values[table.place.get(k)];
  if (!column || last <= first) return;
  const [scale] = shown(channel);
  const planned = PLANNED.test(channel[0]);
  context.strokeStyle = color(ink);
  context.lineWidth = width ?? (planned ? 1.5 : 1.7);
  context.setLineDash(planned ? [7, 5] : []);
  context.lineJoin = "round";
  context.beginPath();
  let [pixel, low, high, open] = [null, 0, 0, false];
  const flush = () => {
    if (pixel === null) return;
    if (open) context.lineTo(pixel, y(low));
    else context.moveTo(pixel, y(low));
    if (high !== low) context.lineTo(pixel, y(high));
    open = true;
  };
  for (let row = first; row < last; row += 1) {
    const value = column[row] * scale;
    if (Number.isNaN(value)) {
      flush();
      [pixel, open] = [null, false];
      continue;
    }
    const at = Math.round(x(table.t[row]) * 2) / 2;
    if (at !== pixel) {
      flush();
      [pixel, low, high] = [at, value, value];
    } else if (value < low) low = value;
    else if (value > high) high = value;
  }
  flush();
  context.stroke();
  context.setLineDash([]);
}
