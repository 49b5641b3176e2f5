// One pane of the scope: traces of one quantity over time, or one over another.

import { color, prepare, watermark } from "./look.js";
import { save } from "./save.js";
import { Trigger } from "./trigger.js";
import { drawXY } from "./xy.js";
import { number, shown, tick, ticks } from "./units.js";

const LEFT = 50;
const RIGHT = 12;
const TOP = 6;
const BOTTOM = 20;
const INKS = 8;
const MOST_BOUNDS = 4;
const UNSEEN = 1e-5; // of the height of a pane
const PLANNED = /^(reference|plan|applied|command)\./;
const SHORT = { reference: " ref", plan: "", applied: " sent", command: " asked" };

// Names as short as they can be told apart: without the group, and without what all begin with.
function brief(columns) {
  const bare = columns.map(([k, name]) => [k, name, name.replace(/^[^.]*\./, "").split("_")]);
  let same = 0;
  const [, , first] = bare[0] ?? [0, "", []];
  const different = new Set(bare.map(([, , words]) => words.join("_"))).size > 1;
  while (different && bare.every(([, , words]) => words.length > same + 1 && words[same] === first[same])) {
    same += 1;
  }
  const told = bare.map(([k, name, words]) => {
    const group = PLANNED.exec(name);
    const text = words.slice(same).join(" ");
    return [k, name, group ? `${text}${SHORT[group[1]]}` : text];
  });
  return new Map(told.map(([k, name, text]) => {
    const isTwice = told.some(([other, , like]) => other !== k && like === text);
    return [k, isTwice ? `${text}, ${name.replace(/\..*/, "")}` : text];
  }));
}

export class Pane {
  // `board` knows the columns, their bounds and the events, and what the window is.
  constructor(board, described) {
    this.board = board;
    this.title = described.title;
    this.columns = described.columns.slice();
    this.hidden = new Set();
    this.isXY = described.xy ?? false;
    this.trigger = null; // its level is that of the first channel, as it is shown
    this.build();
  }

  build() {
    this.element = document.createElement("article");
    this.element.className = "pane";
    const header = document.createElement("header");
    const title = document.createElement("h2");
    this.heading = title;
    this.traces = document.createElement("div");
    this.traces.className = "traces";
    const tools = document.createElement("div");
    tools.className = "tools";
    this.tool(tools, "channels", "choose channels", () => this.board.picker.open(this));
    this.holder = this.tool(tools, "hold", "hold the page still at a level", () => this.turnTrigger());
    this.tool(tools, "xy", "first channel across, second up", () => { this.isXY = !this.isXY; });
    this.tool(tools, "csv", "save what is shown", () => save(this.board, this));
    this.tool(tools, "×", "close this pane", () => this.board.close(this));
    header.append(title, this.traces, tools);
    const plot = document.createElement("div");
    plot.className = "plot";
    this.canvas = document.createElement("canvas");
    plot.append(this.canvas);
    this.element.append(header, plot);
    this.listen();
    this.list();
  }

  tool(tools, text, title, act) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = text;
    button.title = title;
    button.addEventListener("click", act);
    tools.append(button);
    return button;
  }

  listen() {
    const at = (event) => this.timeAt(event.clientX - this.canvas.getBoundingClientRect().left);
    this.canvas.addEventListener("pointermove", (event) => {
      if (this.drag && !this.isXY) {
        this.board.moment.pan(this.drag - at(event));
        return;
      }
      this.board.cursor = this.isXY ? null : at(event);
    });
    this.canvas.addEventListener("pointerdown", (event) => {
      if (event.shiftKey) this.dropTrigger(event.clientY);
      else if (event.pointerType === "touch") this.board.cursor = at(event);
      else this.drag = at(event);
    });
    for (const end of ["pointerup", "pointercancel"]) {
      this.canvas.addEventListener(end, () => { this.drag = null; });
    }
    this.canvas.addEventListener("pointerleave", () => { this.board.cursor = null; });
    this.canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.shiftKey && !event.altKey) event.preventDefault();
      this.board.moment.zoom(Math.exp(event.deltaY * 0.0015), at(event));
    }, { passive: false });
    this.canvas.addEventListener("dblclick", (event) => this.board.moment.jump(at(event)));
  }

  // The tool goes through the ways of a trigger, from one in the middle to none.
  turnTrigger() {
    if (this.trigger) this.setTrigger(this.trigger.next);
    else if (this.upwards) this.setTrigger(new Trigger(0.5 * (this.upwards[0] + this.upwards[1])));
  }

  // Shift and a click put the level there.
  dropTrigger(clientY) {
    if (!this.upwards) return;
    const y = clientY - this.canvas.getBoundingClientRect().top - TOP;
    const share = y / Math.max(this.canvas.clientHeight - TOP - BOTTOM, 1);
    const level = this.upwards[1] - share * (this.upwards[1] - this.upwards[0]);
    this.setTrigger(new Trigger(level, this.trigger?.way));
  }

  setTrigger(trigger) {
    this.trigger = trigger;
    this.holder.textContent = trigger ? `hold ${trigger.way}` : "hold";
    this.holder.title = trigger ? trigger.title : "hold the page still at a level";
  }

  timeAt(x) {
    const [from, to] = this.board.moment.window;
    const share = (x - LEFT) / Math.max(this.canvas.clientWidth - LEFT - RIGHT, 1);
    return from + (to - from) * Math.min(Math.max(share, 0), 1);
  }

  // Channels of one quantity share a colour: what is wanted of it is dashed.
  list() {
    const bases = [];
    const names = brief(this.columns.map((k) => [k, this.board.columns[k][0]]));
    const planned = this.columns.filter((k) => PLANNED.test(this.board.columns[k][0])).length;
    this.inks = new Map();
    this.values = new Map();
    this.traces.replaceChildren(...this.columns.map((k) => {
      const name = this.board.columns[k][0];
      const base = name.replace(/^(reference|reading|estimate|plan)\./, "").replace(/^pressure_/, "");
      const plain = base.replace(/^applied\.|^command\./, "");
      if (!bases.includes(plain)) bases.push(plain);
      const alone = PLANNED.test(name) && this.columns.length === 2 && planned === 1;
      this.inks.set(k, `trace-${alone ? 1 : bases.indexOf(plain) % INKS}`);
      const entry = document.createElement("button");
      entry.type = "button";
      entry.className = PLANNED.test(name) ? "trace planned" : "trace";
      entry.title = this.board.columns[k][2];
      entry.dataset.column = name;
      const sample = document.createElement("i");
      sample.style.borderColor = `var(--${this.inks.get(k)})`;
      const value = document.createElement("b");
      this.values.set(k, value);
      entry.append(sample, names.get(k), value);
      entry.addEventListener("click", () => {
        if (!this.hidden.delete(k)) this.hidden.add(k);
        entry.classList.toggle("off", this.hidden.has(k));
      });
      return entry;
    }));
    const units = new Set(this.columns.map((k) => shown(this.board.columns[k])[1]));
    [this.unit] = units.size === 1 ? units : [""];
    const told = document.createElement("small");
    told.textContent = this.unit;
    this.heading.replaceChildren(this.title, " ", told);
  }

  get seen() {
    return this.columns.filter((k) => !this.hidden.has(k));
  }

  draw() {
    const { context, width, height } = prepare(this.canvas);
    const area = { x: LEFT, y: TOP, w: width - LEFT - RIGHT, h: height - TOP - BOTTOM };
    if (area.w < 20 || area.h < 20) return;
    watermark(context, width, height, this.board.mark, Math.min(34, height / 3));
    const table = this.board.rows.table;
    if (this.isXY) drawXY(this, context, table, area);
    else this.drawTime(context, table, area);
    this.tellValues(table);
  }

  // What nobody could see in the pane is nothing: a joint at rest is at 0, and not at 4e-5 degrees.
  get least() {
    return this.upwards && this.unit ? UNSEEN * (this.upwards[1] - this.upwards[0]) : 0;
  }

  tellValues(table) {
    const t = this.board.cursor ?? this.board.moment.head;
    const row = table.nearest(t);
    for (const [k, element] of this.values) {
      const column = table.values[table.place.get(k)];
      const [scale, unit] = shown(this.board.columns[k]);
      const value = column && row >= 0 ? column[row] : NaN;
      const told = number(Math.abs(value * scale) < this.least ? 0 : value * scale);
      element.textContent = this.unit ? told : `${told} ${unit}`;
      element.dataset.value = value;
      element.dataset.t = row >= 0 ? table.t[row] : "";
    }
  }

  drawTime(context, table, area) {
    const [from, to] = this.board.moment.window;
    const first = Math.max(table.rowAt(from) - 1, 0);
    const last = Math.min(table.rowAt(to) + 1, table.count);
    const range = this.range(table, first, last);
    const x = (t) => area.x + (t - from) / (to - from) * area.w;
    const y = (value) => area.y + (range[1] - value) / (range[1] - range[0]) * area.h;
    this.frame(context, area, [from, to], range, x, y, "s");
    this.drawEvents(context, area, x, from, to);
    context.save();
    context.beginPath();
    context.rect(area.x, area.y, area.w, area.h);
    context.clip();
    const other = this.board.rows.other;
    context.globalAlpha = 0.45;
    for (const k of this.seen) {
      this.trace(context, other, k, other.rowAt(from), other.rowAt(to), x, y, 0.9);
    }
    context.globalAlpha = 1;
    for (const k of this.seen) this.trace(context, table, k, first, last, x, y);
    context.restore();
    this.drawBounds(context, area, range, y);
    this.upwards = range;
    if (this.trigger) this.drawTrigger(context, area, y(this.trigger.level));
    this.line(context, area, x(this.board.moment.head), "quiet");
    if (this.board.cursor !== null) this.line(context, area, x(this.board.cursor), "ink");
  }

  range(table, first, last) {
    let [low, high] = [Infinity, -Infinity];
    for (const k of this.seen) {
      const column = table.values[table.place.get(k)];
      if (!column) continue;
      const scale = shown(this.board.columns[k])[0];
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

  frame(context, area, across, up, x, y, unit) {
    context.font = "11px system-ui, 'DejaVu Sans', sans-serif";
    context.strokeStyle = color("grid");
    context.fillStyle = color("quiet");
    context.lineWidth = 1;
    context.textAlign = "right";
    context.textBaseline = "middle";
    const rungs = ticks(...up, Math.max(2, area.h / 34));
    for (const value of rungs) {
      const at = Math.round(y(value)) + 0.5;
      context.beginPath();
      context.moveTo(area.x, at);
      context.lineTo(area.x + area.w, at);
      context.stroke();
      context.fillText(tick(value, rungs), area.x - 6, at);
    }
    context.textAlign = "center";
    context.textBaseline = "top";
    const stops = ticks(...across, Math.max(2, area.w / 90));
    for (const value of stops) {
      const at = Math.round(x(value)) + 0.5;
      context.beginPath();
      context.moveTo(at, area.y);
      context.lineTo(at, area.y + area.h);
      context.stroke();
      if (at < area.x + area.w - 34) context.fillText(tick(value, stops), at, area.y + area.h + 4);
    }
    context.textAlign = "right";
    context.fillText(unit, area.x + area.w, area.y + area.h + 4);
  }

  drawBounds(context, area, range, y) {
    const drawn = new Set();
    const all = new Set(this.seen.flatMap((k) => this.board.bounds.get(k) ?? []));
    all.delete(null);
    if (all.size > MOST_BOUNDS) return; // of six joints nobody could tell whose they are
    for (const k of this.seen) {
      const bound = this.board.bounds.get(k);
      if (!bound) continue;
      const [scale, unit] = shown(this.board.columns[k]);
      for (const limit of bound) {
        if (limit === null) continue;
        const value = limit * scale;
        if (drawn.has(value)) continue;
        drawn.add(value);
        context.strokeStyle = context.fillStyle = color("limit");
        if (value > range[0] && value < range[1]) {
          context.setLineDash([6, 4]);
          context.beginPath();
          context.moveTo(area.x, y(value));
          context.lineTo(area.x + area.w, y(value));
          context.stroke();
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

  drawEvents(context, area, x, from, to) {
    for (const event of this.board.events.all) {
      if (event.t === null || event.t < from || event.t > to) continue;
      const ink = { fault: "alarm", tuning: "trace-3", limit: "reference" }[event.kind] ?? "quiet";
      // Only what is rare crosses the whole pane; the others are marks at its foot.
      const whole = event.kind === "fault" || event.kind === "tuning";
      const foot = whole ? area : { ...area, y: area.y + area.h - 7, h: 7 };
      this.line(context, foot, x(event.t), ink);
    }
  }

  line(context, area, at, ink) {
    if (at < area.x || at > area.x + area.w) return;
    context.strokeStyle = color(ink);
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(at, area.y);
    context.lineTo(at, area.y + area.h);
    context.stroke();
  }

  drawTrigger(context, area, at) {
    context.strokeStyle = context.fillStyle = color("good");
    context.setLineDash([2, 3]);
    context.beginPath();
    context.moveTo(area.x, at);
    context.lineTo(area.x + area.w, at);
    context.stroke();
    context.setLineDash([]);
    context.textAlign = "left";
    context.textBaseline = "bottom";
    context.fillText(`hold ${this.trigger.way} ${number(this.trigger.level)}`, area.x + 4, at - 2);
  }

  // Where there are more rows than pixels, each pixel gets the least and the greatest of its rows.
  trace(context, table, k, first, last, x, y, width = null) {
    const column = table.values[table.place.get(k)];
    if (!column || last <= first) return;
    const [scale] = shown(this.board.columns[k]);
    const planned = PLANNED.test(this.board.columns[k][0]);
    context.strokeStyle = color(this.inks.get(k));
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
}
