// One channel over another: the first across, the second up; in equal scales if they can be.

import { frame } from "./axes.js";
import { color } from "./look.js";
import { shown } from "./units.js";

export function drawXY(pane, context, table, area) {
  const [from, to] = pane.board.moment.window;
  const first = table.rowAt(from);
  const last = table.rowAt(to);
  const pairs = [];
  for (let k = 0; k + 1 < pane.columns.length; k += 2) {
    pairs.push([pane.columns[k], pane.columns[k + 1]]);
  }
  const spread = [Infinity, -Infinity, Infinity, -Infinity];
  const read = (k) => [table.values[table.place.get(k)], shown(pane.board.columns[k])[0]];
  for (const [a, b] of pairs) {
    const [[u, us], [v, vs]] = [read(a), read(b)];
    if (!u || !v) return;
    for (let row = first; row < last; row += 1) {
      spread[0] = Math.min(spread[0], u[row] * us);
      spread[1] = Math.max(spread[1], u[row] * us);
      spread[2] = Math.min(spread[2], v[row] * vs);
      spread[3] = Math.max(spread[3], v[row] * vs);
    }
  }
  if (!(spread[1] >= spread[0])) return;
  const [mx, my] = [0.5 * (spread[0] + spread[1]), 0.5 * (spread[2] + spread[3])];
  const wide = 1.12 * Math.max((spread[1] - spread[0]) / area.w, 1e-9);
  const tall = 1.12 * Math.max((spread[3] - spread[2]) / area.h, 1e-9);
  const [[, unit], [, other]] = pairs[0].map((k) => shown(pane.board.columns[k]));
  const [px, py] = unit === other ? [Math.max(wide, tall), Math.max(wide, tall)] : [wide, tall];
  const across = [mx - 0.5 * px * area.w, mx + 0.5 * px * area.w];
  const up = [my - 0.5 * py * area.h, my + 0.5 * py * area.h];
  const x = (value) => area.x + (value - across[0]) / px;
  const y = (value) => area.y + (up[1] - value) / py;
  frame(context, area, across, up, x, y, unit);
  for (const [a, b] of pairs) {
    const [[u, us], [v, vs]] = [read(a), read(b)];
    context.strokeStyle = color(pane.inks.get(a));
    context.lineWidth = 1.6;
    context.beginPath();
    for (let row = first; row < last; row += 1) context.lineTo(x(u[row] * us), y(v[row] * vs));
    context.stroke();
  }
}
