// One pane of the scope: traces of one quantity over time, or one over another.

import { drawBounds, drawEvents, drawTrigger, frame, line } from "./axes.js";
import { prepare, watermark } from "./look.js";
import { PLANNED, brief } from "./names.js";
import { save } from "./save.js";
import { range, trace } from "./traces.js";
import { Trigger } from "./trigger.js";
import { number, shown } from "./units.js";
import { drawXY } from "./xy.js";

const LEFT = 50;
const RIGHT = 12;
const TOP = 6;
const BOTTOM = 20;
const INKS = 8;
const UNSEEN = 1e-5; // of the height of a pane

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
    const span = range(this.board, this.seen, table, first, last);
    const x = (t) => area.x + (t - from) / (to - from) * area.w;
    const y = (value) => area.y + (span[1] - value) / (span[1] - span[0]) * area.h;
    frame(context, area, [from, to], span, x, y, "s");
    drawEvents(this.board.events.all, context, area, x, from, to);
    context.save();
    context.beginPath();
    context.rect(area.x, area.y, area.w, area.h);
    context.clip();
    const other = this.board.rows.other;
    context.globalAlpha = 0.45;
    const drawn = this.seen.map((k) => ({ k, channel: this.board.columns[k], ink: this.inks.get(k) }));
    for (const one of drawn) {
      trace(context, other, one, other.rowAt(from), other.rowAt(to), x, y, 0.9);
    }
    context.globalAlpha = 1;
    for (const one of drawn) trace(context, table, one, first, last, x, y);
    context.restore();
    drawBounds(this.board, this.seen, context, area, span, y);
    this.upwards = span;
    if (this.trigger) drawTrigger(this.trigger, context, area, y(this.trigger.level));
    line(context, area, x(this.board.moment.head), "quiet");
    if (this.board.cursor !== null) line(context, area, x(this.board.cursor), "ink");
  }
}
