// What the server is asked for, and what of it is here: rows of channels, and frames of the scene.

import { Table } from "./table.js";
import { shown } from "./units.js";

const KEEP = 60; // s of rows that a page which follows the run asks for at first
const MOST_COLUMNS = 256;
const SOON = 60; // ms after the last move of a window that it is asked for
const AGAIN = { frames: 500, beside: 1000 }; // ms between two of the same wish

export class Rows {
  constructor(board) {
    this.board = board;
    this.columns = null; // those that panes show
    this.live = new Table([]);
    this.fixed = new Table([]);
    this.other = new Table([]); // of the run beside this one
    this.framesOf = null; // the time that frames were asked for
  }

  get table() {
    return this.board.moment.isLive ? this.live : this.fixed;
  }

  ask(message) {
    return this.board.link.ask(message);
  }

  // The columns of all panes, as they come from now on and as they were.
  subscribe() {
    const { panes, status, moment } = this.board;
    this.columns = [...new Set(panes.flatMap((pane) => pane.columns))].slice(0, MOST_COLUMNS);
    this.live = new Table(this.columns);
    if (status?.live) {
      this.following = this.ask({ type: "follow", columns: this.columns, seconds: KEEP });
    }
    if (!moment.isLive) this.view();
  }

  view() {
    clearTimeout(this.soon);
    this.soon = setTimeout(() => {
      const { still } = this.board.moment;
      if (!still || !this.columns?.length) return;
      const [from, to] = still;
      const most = Math.min(4 * innerWidth, 6000);
      this.viewing = this.ask({ type: "view", columns: this.columns, from, to, most });
      this.viewBeside(from, to);
    }, SOON);
  }

  viewBeside(from, to) {
    if (!this.board.described.beside || !this.columns?.length) return;
    const message = { type: "beside", columns: this.columns, from, to, most: 2 * innerWidth };
    this.besideOf = this.ask(message);
    this.besideAt = performance.now();
  }

  // The scene while the page holds still: a while before the moment, and what will be played next.
  viewFrames(head) {
    const { scene, status } = this.board;
    if (!scene.shapes.length || !status?.count) return;
    const back = scene.longest + 1;
    const [from, to] = [Math.max(head - back - 4, 0), head + 10];
    const held = this.framesOf;
    const covers = held && head - back >= held[0] - 1e-9 - (held[0] <= 0 ? back : 0)
      && (head + 3 <= held[1] || held[1] >= status.t);
    // A log that still grows, or is still being read, may have had less when it was asked for.
    if (covers || (held && performance.now() - this.framedAt < AGAIN.frames)) return;
    this.framedAt = performance.now();
    this.framesOf = [from, Math.min(to, status.t)];
    this.framing = this.ask({ type: "frames", from, to, most: 600 });
  }

  // What has a way of its own on the scene has come it before the page was opened.
  recallFrames() {
    const { columns, scene, status } = this.board;
    const [to, back] = [status?.t ?? 0, scene.longest];
    if (!columns.length || !to || !back) return;
    this.recalling = this.ask({ type: "frames", from: to - back, to, most: 300 });
  }

  // What the moment that is shown needs and is not yet here.
  keepUp(now) {
    const { isLive, head, span } = this.board.moment;
    if (!isLive) this.viewFrames(head);
    else if (now - (this.besideAt ?? 0) > AGAIN.beside) this.viewBeside(head - span, head + 2);
  }

  // What the server has sent ----------------------------------------------------------

  take(block) {
    if (block.id === this.following) {
      const before = this.live.count;
      this.live.add(block);
      if (this.board.moment.isLive && before) this.pullTriggers(block.count);
    }
    if (block.id === this.viewing) {
      this.fixed = new Table(this.columns);
      this.fixed.add(block);
    }
  }

  takeBeside(block) {
    if (block.id !== this.besideOf) return;
    this.other = new Table(this.columns);
    this.other.add(block);
  }

  takeFrames(block) {
    const { scene, moment } = this.board;
    const isLive = block.id === 0 || block.id === this.recalling;
    if (isLive && moment.isLive) scene.take(block, true);
    else if (!isLive && block.id === this.framing) scene.take(block, false);
  }

  // The page holds still where a pane's trigger says so: what was before it counts.
  pullTriggers(fresh) {
    const { panes, columns, moment } = this.board;
    const table = this.live;
    for (const pane of panes) {
      const column = table.values[table.place.get(pane.seen[0])];
      if (!pane.trigger || !column) continue;
      const [scale] = shown(columns[pane.seen[0]]);
      for (let row = Math.max(table.count - fresh, 1); row < table.count; row += 1) {
        if (pane.trigger.fires(column[row - 1] * scale, column[row] * scale)) {
          pane.setTrigger(null);
          moment.jump(table.t[row]);
          return;
        }
      }
    }
  }
}
