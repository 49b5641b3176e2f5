// The page as a whole: what the server says, handed on to who shows it.

import { tellAge, tellLoss, tellMoment, tellRun, tellState } from "./bar.js";
import { Cameras } from "./camera.js";
import { listen } from "./controls.js";
import { Events } from "./events.js";
import { tellCycle, tellMargins } from "./facts.js";
import { Gains } from "./gains.js";
import { layout } from "./layouts.js";
import { Link } from "./link.js";
import { forget } from "./look.js";
import { Moment } from "./moment.js";
import { Picker } from "./picker.js";
import { Rows } from "./rows.js";
import { Scene } from "./scene.js";
import { Pane } from "./scope.js";

const FRAME_TIME = 1000 / 30;
const element = (id) => document.getElementById(id);

class Board {
  constructor() {
    this.columns = [];
    this.bounds = new Map(); // of columns, by their numbers: [least, greatest]
    this.panes = [];
    this.mark = "";
    this.cursor = null; // s, where a hand points
    this.status = null;
    this.rows = new Rows(this);
    this.moment = new Moment(() => this.rows.view());
    this.events = new Events((t) => this.moment.jump(t), (event) => this.heard(event));
    this.scene = new Scene(element("scene"), element("legend"));
    this.cameras = new Cameras(this, element("cameras"));
    this.picker = new Picker(this);
    const [token, ...rest] = location.hash.slice(1).split("&");
    this.asked = new URLSearchParams(rest.join("&"));
    this.token = token;
    listen(this);
    if (token) this.connect(token);
  }

  connect(token) {
    this.link = new Link(token, {
      hello: (message) => this.hello(message),
      status: (message) => this.tell(message),
      events: (message) => this.tellEvents(message.events),
      steered: (message) => this.gains.answer(message),
      refused: (message) => this.gains.tell(message.message),
      rows: (block) => this.rows.take(block),
      frames: (block) => this.rows.takeFrames(block),
      beside: (block) => this.rows.takeBeside(block),
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
    this.mark = this.scene.mark = message.simulated ? "SIMULATED" : "HARDWARE";
    tellRun(message, this.mark);
    forget(); // the colours of the other kind
    this.cameras.describe(message.cameras);
    element("stage").hidden = this.columns.length > 0 && !message.scene.shapes?.length;
    element("scene-note").textContent = message.scene.trouble ?? "";
    this.gains.describe(message.gains, message.steers, !message.simulated);
    for (const event of this.events.all) if (event.kind === "tuning") this.gains.heard(event);
    this.show(message);
  }

  // What somebody has arranged stays when the server says the same once more.
  show(message) {
    const told = JSON.stringify([message.columns, message.scene]);
    if (told === this.laid) {
      this.rows.subscribe();
      return;
    }
    this.laid = told;
    if (message.scene.shapes) this.scene.describe(message.scene);
    if (this.moment.isLive) this.rows.recallFrames();
    if (this.columns.length) this.lay(layout(this));
  }

  tell(message) {
    this.status = message;
    this.statusAt = performance.now();
    this.moment.last = message.count ? message.t : null;
    tellState(message);
    this.start(message);
    if (message.trouble) element("scene-note").textContent = message.trouble;
    tellCycle(message, this.described?.simulated);
    tellMargins(message, this.columns);
    this.gains.show(message.live);
    this.events.mark(message.t);
  }

  // At first a run that goes on is followed, and one that has ended is shown as a whole: a long
  // log may still be on its way, and then the whole of it grows.
  start(message) {
    const isAsked = this.asked.has("t");
    const isWhole = this.whole !== null && this.moment.still?.[1] === this.whole;
    if (this.whole === undefined && message.live && !isAsked) {
      this.whole = null;
      this.follow();
    } else if (message.count && (this.whole === undefined || (isWhole && this.whole !== message.t))) {
      this.whole = message.t;
      this.moment.hold(0, message.t);
      if (isAsked) this.moment.goTo(this.asked);
    }
  }

  tellEvents(events) {
    this.events.add(events);
    this.events.mark(this.status?.t);
  }

  heard(event) {
    if (event.kind === "fault" && event.t !== null && this.moment.isLive) this.moment.jump(event.t);
    if (event.kind === "tuning") this.gains.heard(event);
  }

  lost(code) {
    tellLoss(code);
    this.status = null;
    this.whole = undefined; // once there is a server again, as at first
    this.events.clear();
  }

  follow() {
    this.moment.follow();
    this.rows.framesOf = null;
    this.scene.frames = [];
    this.rows.recallFrames();
    if (this.panes.length) this.rows.subscribe();
  }

  // Which panes there are ------------------------------------------------------------

  get key() {
    return `rig-layout:${this.described.rig}`;
  }

  lay(panes) {
    this.panes = panes.map((pane) => new Pane(this, pane));
    element("panes").replaceChildren(...this.panes.map((pane) => pane.element));
    this.rows.subscribe();
  }

  close(pane) {
    this.panes = this.panes.filter((other) => other !== pane);
    pane.element.remove();
    this.rows.subscribe();
  }

  // Drawing --------------------------------------------------------------------------

  frame(now) {
    requestAnimationFrame((next) => this.frame(next));
    const passed = now - (this.drawnAt ?? 0);
    if (passed < FRAME_TIME - 4) return;
    this.drawnAt = now;
    if (!this.status) return;
    tellAge(this.status, (now - this.statusAt) / 1000);
    if (!this.columns.length) return;
    this.moment.advance(Math.min(passed / 1000, 0.5), this.rows.live.last, this.status.live);
    this.rows.keepUp(now);
    this.scene.draw(this.moment.head);
    this.cameras.draw(now);
    for (const pane of this.panes) pane.draw();
    tellMoment(this.moment);
  }
}

const board = new Board();
window.board = board; // for whoever looks at the page from a console, and for its tests
