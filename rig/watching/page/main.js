// The page as a whole: what is shown of which moment, and who is told of it.

import { Cameras } from "./camera.js";
import { listen } from "./controls.js";
import { tellCycle, tellMargins } from "./facts.js";
import { Gains } from "./gains.js";
import { layout } from "./layouts.js";
import { Link } from "./link.js";
import { forget } from "./look.js";
import { Picker } from "./picker.js";
import { Scene } from "./scene.js";
import { Pane } from "./scope.js";
import { Table } from "./table.js";
import { number, seconds, shown } from "./units.js";

const PHASES = { "-1": "–", 0: "approach", 1: "run", 2: "stop" };
const OLD = 1.0; // s; older data are marked
const KEEP = 60; // s of rows that a live page asks for at first
const FRAME_TIME = 1000 / 30;
const element = (id) => document.getElementById(id);

class Board {
  constructor() {
    this.columns = [];
    this.bounds = new Map();
    this.events = [];
    this.panes = [];
    this.mark = "";
    this.cursor = null;
    this.isLive = false;
    this.isPlaying = false;
    this.head = 0;
    this.span = 10;
    this.still = null; // the window while it does not move: [from, to]
    this.live = new Table([]);
    this.fixed = new Table([]);
    this.other = new Table([]); // the run beside this one
    this.status = null;
    this.statusAt = performance.now();
    this.scene = new Scene(element("scene"), element("legend"));
    this.cameras = new Cameras(this, element("cameras"));
    this.picker = new Picker(this);
    this.framesOf = null; // the time that frames were asked for
    const [token, ...rest] = location.hash.slice(1).split("&");
    this.asked = new URLSearchParams(rest.join("&"));
    this.token = token;
    listen(this);
    if (!token) return;
    this.link = new Link(token, {
      hello: (message) => this.hello(message),
      status: (message) => this.tell(message),
      events: (message) => this.tellEvents(message),
      steered: (message) => this.gains.answer(message),
      refused: (message) => { element("gain-said").textContent = message.message; },
      rows: (block) => this.rows(block),
      frames: (block) => this.frames(block),
      beside: (block) => this.layBeside(block),
      camera: (block, data) => this.cameras.take(block, data),
      lost: (code) => this.lost(code),
    });
    this.gains = new Gains(this.link);
    requestAnimationFrame((now) => this.frame(now));
  }

  // What the server says -------------------------------------------------------------

  hello(message) {
    this.described = message;
    this.columns = message.columns;
    this.bounds = new Map((message.scene.bounds ?? []).map(([k, low, high]) => [k, [low, high]]));
    this.mark = message.simulated ? "SIMULATED" : "HARDWARE";
    document.documentElement.classList.toggle("hardware", !message.simulated);
    forget();
    document.title = `${this.mark} · ${message.experiment} · rig`;
    element("kind").textContent = this.mark;
    element("title").textContent = message.experiment;
    const seed = message.seed === null ? "" : `, seed ${message.seed}`;
    const beside = message.beside ? ` · beside ${message.beside}` : "";
    element("subtitle").textContent =
      `${message.rig} · ${message.law} · ${message.backend}${seed} · ${message.run}${beside}`;
    this.scene.mark = this.mark;
    this.cameras.describe(message.cameras);
    element("stage").hidden = this.columns.length > 0 && !message.scene.shapes?.length;
    element("scene-note").textContent = message.scene.trouble ?? "";
    this.gains.describe(message.gains, message.steers, !message.simulated);
    for (const event of this.events) if (event.kind === "tuning") this.gains.heard(event);
    this.show(message);
  }

  // What somebody has arranged stays when the server says the same once more.
  show(message) {
    const told = JSON.stringify([message.columns, message.scene]);
    if (told === this.laid) {
      this.subscribe();
      return;
    }
    this.laid = told;
    if (message.scene.shapes) this.scene.describe(message.scene);
    if (this.isLive) this.recall();
    if (this.columns.length) this.lay(layout(this));
  }

  tell(message) {
    this.status = message;
    this.statusAt = performance.now();
    this.age = message.live ? message.age : 0;
    element("phase").textContent = message.live ? PHASES[message.phase] ?? "–" : message.state;
    element("phase").title = message.message ?? "";
    element("time").textContent = message.count ? seconds(message.t) : "–";
    this.start(message);
    if (message.trouble) element("scene-note").textContent = message.trouble;
    tellCycle(message, this.described?.simulated);
    tellMargins(message, this.columns);
    element("live").hidden = !message.live;
    this.gains.show(message.live);
    element("slider").max = message.t || 1;
    this.markEvents();
  }

  // At first a run that goes on is followed, and one that has ended is shown as a whole: a long
  // log may still be on its way, and then the whole of it grows.
  start(message) {
    const isAsked = this.asked.has("t");
    if (this.whole === undefined && message.live && !isAsked) {
      this.whole = null;
      this.follow();
    } else if (message.count && (this.whole === undefined
        || (this.whole !== null && this.whole !== message.t && this.still?.[1] === this.whole))) {
      this.whole = message.t;
      this.hold(0, message.t);
      if (isAsked) this.goTo(this.asked);
    }
  }

  goTo(asked) {
    const [t, w] = [Number(asked.get("t")), Number(asked.get("w") || 10)];
    if (!Number.isFinite(t) || !(w > 0)) return;
    this.hold(t - w / 2, t + w / 2);
    this.head = t;
  }

  tellEvents(message) {
    const list = element("events");
    for (const event of message.events) {
      this.events.push(event);
      const entry = document.createElement("li");
      entry.className = event.kind;
      const time = document.createElement("time");
      time.textContent = event.t === null ? "–" : `${number(event.t, 4)} s`;
      const text = document.createElement("span");
      text.textContent = event.kind === "state" ? event.message.replace("->", "→") : event.message;
      entry.append(time, text);
      entry.addEventListener("click", () => event.t !== null && this.jump(event.t));
      list.prepend(entry);
      if (event.kind === "fault" && event.t !== null && this.isLive) this.jump(event.t);
      if (event.kind === "tuning") this.gains.heard(event);
    }
    if (this.events.length > 2000) this.events.splice(0, this.events.length - 2000);
    this.markEvents();
  }

  rows(block) {
    if (block.id === this.following) {
      const before = this.live.count;
      this.live.add(block);
      if (this.isLive && before) this.watchTriggers(block.count);
    }
    if (block.id === this.viewing) {
      this.fixed = new Table(this.shownColumns);
      this.fixed.add(block);
    }
  }

  // The page holds still where a pane's trigger says so: what was before it counts.
  watchTriggers(fresh) {
    const table = this.live;
    for (const pane of this.panes) {
      const column = table.values[table.place.get(pane.seen[0])];
      if (!pane.trigger || !column) continue;
      const [scale] = shown(this.columns[pane.seen[0]]);
      for (let row = Math.max(table.count - fresh, 1); row < table.count; row += 1) {
        if (pane.trigger.fires(column[row - 1] * scale, column[row] * scale)) {
          pane.setTrigger(null);
          this.jump(table.t[row]);
          return;
        }
      }
    }
  }

  layBeside(block) {
    if (block.id !== this.besideOf) return;
    this.other = new Table(this.shownColumns);
    this.other.add(block);
  }

  frames(block) {
    if (block.id === 0) {
      if (this.isLive) this.scene.take(block, true);
    } else if (block.id === this.recalling) {
      if (this.isLive) this.scene.take(block, true);
    } else if (block.id === this.framing) {
      this.scene.take(block, false);
    }
  }

  lost(code) {
    element("age").textContent = code === 4401 ? "refused" : "no server";
    element("age").className = "old";
    if (code === 4401) {
      element("subtitle").textContent = "The token of this address is not the server's. Stop works.";
    }
    this.status = null;
    this.whole = undefined; // once there is a server again, as at first
    this.events = [];
    element("events").replaceChildren();
  }

  // Which panes there are ------------------------------------------------------------

  get key() {
    return `rig-layout:${this.described.rig}`;
  }

  lay(panes) {
    this.panes = panes.map((pane) => new Pane(this, pane));
    element("panes").replaceChildren(...this.panes.map((pane) => pane.element));
    this.subscribe();
  }

  subscribe() {
    this.shownColumns = [...new Set(this.panes.flatMap((pane) => pane.columns))].slice(0, 256);
    this.live = new Table(this.shownColumns);
    if (this.status?.live) {
      this.following = this.link.ask({ type: "follow", columns: this.shownColumns, seconds: KEEP });
    }
    if (!this.isLive) this.view();
  }

  close(pane) {
    this.panes = this.panes.filter((other) => other !== pane);
    pane.element.remove();
    this.subscribe();
  }

  // Which moment is shown ------------------------------------------------------------

  follow() {
    this.isLive = true;
    this.isPlaying = false;
    this.still = null;
    this.framesOf = null;
    this.scene.frames = [];
    this.recall();
    this.head = this.status?.t ?? 0;
    if (this.panes.length) this.subscribe();
    element("live").classList.add("on");
    this.tellWidth();
  }

  // What has a way of its own on the scene has come it before the page was opened.
  recall() {
    const [to, back] = [this.status?.t ?? 0, this.scene.longest];
    if (!this.columns.length || !to || !back) return;
    this.recalling = this.link.ask({ type: "frames", from: to - back, to, most: 300 });
  }

  // The choice of windows says how wide the one that is shown is, whatever has made it so.
  tellWidth() {
    const [from, to] = this.window();
    const isWhole = this.still !== null && from <= 0 && to >= (this.status?.t ?? Infinity);
    const [choice, width] = [element("window"), element("width")];
    const given = [...choice.options].find((one) => Math.abs(Number(one.value) / (to - from) - 1) < 1e-6);
    width.textContent = `${Number((to - from).toPrecision(2))} s`;
    choice.value = isWhole ? "0" : given?.value ?? width.value;
  }

  hold(from, to) {
    this.isLive = false;
    this.still = [from, Math.max(to, from + 1e-3)];
    this.head = Math.min(Math.max(this.head, from), to);
    element("live").classList.remove("on");
    this.tellWidth();
    this.view();
  }

  jump(t) {
    const span = this.still && this.still[1] - this.still[0] < 1e3 ? this.still[1] - this.still[0] : 10;
    if (this.isLive || t < this.window()[0] || t > this.window()[1]) {
      const width = this.isLive ? Math.max(this.span, 10) : span;
      this.hold(t - width, t + 0.1 * width); // what came before it is what one wants to see
    }
    this.head = t;
  }

  pan(by) {
    if (this.isLive) this.hold(...this.window());
    this.hold(this.still[0] + by, this.still[1] + by);
  }

  zoom(factor, about) {
    const [from, to] = this.window();
    if (this.isLive) {
      this.span = Math.min(Math.max(this.span * factor, 0.05), KEEP);
      this.tellWidth();
      return;
    }
    this.hold(about - (about - from) * factor, about + (to - about) * factor);
  }

  window() {
    if (this.still) return this.still;
    return [this.head - this.span, this.head];
  }

  playhead() {
    return this.head;
  }

  table() {
    return this.isLive ? this.live : this.fixed;
  }

  view() {
    clearTimeout(this.viewSoon);
    this.viewSoon = setTimeout(() => {
      if (!this.still || !this.shownColumns?.length) return;
      const [from, to] = this.still;
      const most = Math.min(4 * innerWidth, 6000);
      const message = { type: "view", columns: this.shownColumns, from, to, most };
      this.viewing = this.link.ask(message);
      this.askBeside(from, to);
    }, 60);
  }

  askBeside(from, to) {
    if (!this.described.beside || !this.shownColumns?.length) return;
    const message = { type: "beside", columns: this.shownColumns, from, to, most: 2 * innerWidth };
    this.besideOf = this.link.ask(message);
    this.besideAt = performance.now();
  }

  askFrames() {
    if (!this.scene.shapes.length || !this.status?.count) return;
    const back = this.scene.longest + 1;
    const [from, to] = [Math.max(this.head - back - 4, 0), this.head + 10];
    const held = this.framesOf;
    const covers = held && this.head - back >= held[0] - 1e-9 - (held[0] <= 0 ? back : 0)
      && (this.head + 3 <= held[1] || held[1] >= this.status.t);
    // A log that still grows, or is still being read, may have had less when it was asked for.
    if (covers || (held && performance.now() - this.framedAt < 500)) return;
    this.framedAt = performance.now();
    this.framesOf = [from, Math.min(to, this.status.t)];
    this.framing = this.link.ask({ type: "frames", from, to, most: 600 });
  }

  // Drawing --------------------------------------------------------------------------

  frame(now) {
    requestAnimationFrame((next) => this.frame(next));
    const passed = now - (this.drawnAt ?? 0);
    if (passed < FRAME_TIME - 4) return;
    this.drawnAt = now;
    this.tellAge(now);
    if (!this.columns.length || !this.status) return;
    this.advance(Math.min(passed / 1000, 0.5));
    if (!this.isLive) this.askFrames();
    else if (now - (this.besideAt ?? 0) > 1000) this.askBeside(this.head - this.span, this.head + 2);
    this.scene.draw(this.head);
    this.cameras.draw(now);
    for (const pane of this.panes) pane.draw();
    this.tellMoment();
  }

  advance(passed) {
    if (this.isLive) {
      const last = Math.max(this.live.last, this.status.t ?? 0);
      const behind = last - this.head;
      this.head += behind > 2 ? behind : behind * (1 - Math.exp(-passed / 0.15));
      return;
    }
    if (!this.isPlaying) return;
    this.head += passed * Number(element("speed").value);
    if (this.head >= this.status.t) {
      this.head = this.status.t;
      this.isPlaying = this.status.live;
    }
    const [from, to] = this.still;
    if (this.head > to) this.hold(this.head - 0.1 * (to - from), this.head + 0.9 * (to - from));
  }

  tellAge(now) {
    if (!this.status) return;
    const since = Math.max(now - this.statusAt, 0) / 1000; // a frame's time may be before it
    const age = (this.age ?? 0) + (this.status.live ? since : 0);
    element("age").textContent = this.status.live ? `${age.toFixed(1)} s old` : "complete";
    element("age").className = age > OLD ? "old" : "";
  }

  tellMoment() {
    if (document.activeElement !== element("slider") || this.isPlaying || this.isLive) {
      element("slider").value = this.head;
    }
    element("moment").textContent = seconds(this.head);
    element("play").textContent = this.isPlaying || this.isLive ? "❚❚" : "▶";
  }

  markEvents() {
    const last = this.status?.t;
    if (!last) return;
    element("marks").replaceChildren(...this.events.filter((event) => event.t !== null)
      .map((event) => {
        const mark = document.createElement("i");
        mark.className = event.kind;
        mark.style.left = `${100 * event.t / last}%`;
        return mark;
      }));
  }

}

const board = new Board();
window.board = board; // for whoever looks at the page from a console, and for its tests
