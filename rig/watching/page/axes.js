// What a pane draws around and over its traces: ticks, limits, events, the level of a trigger.

import { color } from "./look.js";
import { number, shown, tick, ticks } from "./units.js";

const MOST_BOUNDS = 4;

export function frame(context, area, span, up, x, y, unit) {
  context.font = "11px system-ui, 'DejaVu Sans', sans-serif";
  context.strokeStyle = color("grid");
  context.fillStyle = color("quiet");
  context.lineWidth = 1;
  context.textAlign = "right";
  context.textBaseline = "middle";
  const rungs = ticks(...up, Math.max(2, area.h / 34));
  for (const value of rungs) {
    const at = Math.round(y(value)) + 0.5;
    across(context, area, at);
    context.fillText(tick(value, rungs), area.x - 6, at);
  }
  context.textAlign = "center";
  context.textBaseline = "top";
  const stops = ticks(...span, Math.max(2, area.w / 90));
  for (const value of stops) {
    const at = Math.round(x(value)) + 0.5;
    upright(context, area, at);
    if (at < area.x + area.w - 34) context.fillText(tick(value, stops), at, area.y + area.h + 4);
  }
  context.textAlign = "right";
  context.fillText(unit, area.x + area.w, area.y + area.h + 4);
}

export function drawBounds(board, seen, context, area, range, y) {
  const drawn = new Set();
  const all = new Set(seen.flatMap((k) => board.bounds.get(k) ?? []));
  all.delete(null);
  if (all.size > MOST_BOUNDS) return; // of six joints nobody could tell whose they are
  for (const k of seen) {
    const bound = board.bounds.get(k);
    if (!bound) continue;
    const [scale, unit] = shown(board.columns[k]);
    for (const limit of bound) {
      if (limit === null) continue;
      const value = limit * scale;
      if (drawn.has(value)) continue;
      drawn.add(value);
      context.strokeStyle = context.fillStyle = color("limit");
      if (value > range[0] && value < range[1]) {
        context.setLineDash([6, 4]);
        across(context, area, y(value));
        context.setLineDash([]);
      } else {
        const above = value >= range[1];
        context.textAlign = "right";
        context.textBaseline = above ? "top" : "bottom";
        const text = `${above ? "▲" : "▼"} limit ${number(value)} ${unit}`;
        const long = context.measureText(text).width + 6;
        context.fillStyle = color("card");
        context.fillRect(area.x + area.w - long, above ? area.y : area.y + area.h - 15, long, 15);
        context.fillStyle = color("limit");
        context.fillText(text, area.x + area.w - 4, above ? area.y + 2 : area.y + area.h - 2);
      }
    }
  }
}

export function drawEvents(events, context, area, x, from, to) {
  for (const event of events) {
    if (event.t === null || event.t < from || event.t > to) continue;
    const ink = { fault: "alarm", tuning: "trace-3", limit: "reference" }[event.kind] ?? "quiet";
    // Only what is rare crosses the whole pane; the others are marks at its foot.
    const whole = event.kind === "fault" || event.kind === "tuning";
    const foot = whole ? area : { ...area, y: area.y + area.h - 7, h: 7 };
    line(context, foot, x(event.t), ink);
  }
}

export function line(context, area, at, ink) {
  if (at < area.x || at > area.x + area.w) return;
  context.strokeStyle = color(ink);
  context.lineWidth = 1;
  upright(context, area, at);
}

export function drawTrigger(trigger, context, area, at) {
  context.strokeStyle = context.fillStyle = color("good");
  context.setLineDash([2, 3]);
  across(context, area, at);
  context.setLineDash([]);
  context.textAlign = "left";
  context.textBaseline = "bottom";
  context.fillText(`hold ${trigger.way} ${number(trigger.level)}`, area.x + 4, at - 2);
}

function across(context, area, at) {
  context.beginPath();
  context.moveTo(area.x, at);
  context.lineTo(area.x + area.w, at);
  context.stroke();
}

function upright(context, area, at) {
  context.beginPath();
  context.moveTo(at, area.y);
  context.lineTo(at, area.y + area.h);
  context.stroke();
}
