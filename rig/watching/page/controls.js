// What a person does: the transport at the foot of the page, layouts, links, the space bar.

import { layout } from "./layouts.js";
import { Pane } from "./scope.js";

const element = (id) => document.getElementById(id);

function step(board, forwards) {
  const times = board.events.map((event) => event.t).filter((t) => t !== null).sort((a, b) => a - b);
  const next = forwards ? times.find((t) => t > board.head + 1e-6)
    : times.findLast((t) => t < board.head - 1e-6);
  if (next !== undefined) board.jump(next);
}

// What the buttons and keys of the page do; nothing while there is no server.
export function listen(board) {
  const on = (name, kind, act) => {
    element(name).addEventListener(kind, () => { if (board.status && (board.isLive || board.still)) act(); });
  };
  on("live", "click", () => board.follow());
  on("play", "click", () => {
    if (board.isLive) {
      board.hold(...board.window());
      return;
    }
    board.isPlaying = !board.isPlaying;
    if (board.isPlaying && board.head >= board.status.t) board.head = Math.max(board.still[0], 0);
  });
  on("slider", "input", () => {
    if (board.isLive) board.hold(0, board.status.t);
    board.head = Number(element("slider").value);
    const [from, to] = board.still;
    if (board.head < from || board.head > to) {
      board.hold(board.head - 0.5 * (to - from), board.head + 0.5 * (to - from));
    }
  });
  on("window", "change", () => {
    const span = Number(element("window").value);
    if (board.isLive && span) board.span = span;
    else if (!span) board.hold(0, board.status.t);
    else board.hold(board.head - 0.7 * span, board.head + 0.3 * span);
  });
  on("earlier", "click", () => step(board, false));
  on("later", "click", () => step(board, true));
  element("add").addEventListener("click", () => {
    const pane = new Pane(board, { title: `pane ${board.panes.length + 1}`, columns: [] });
    board.panes.push(pane);
    element("panes").append(pane.element);
    board.picker.open(pane);
  });
  element("save").addEventListener("click", () => {
    const kept = board.panes.map((pane) => ({
      title: pane.title, xy: pane.isXY, names: pane.columns.map((k) => board.columns[k][0]),
    }));
    localStorage.setItem(board.key, JSON.stringify(kept));
  });
  element("reset").addEventListener("click", () => {
    localStorage.removeItem(board.key);
    board.lay(layout(board));
  });
  element("link").addEventListener("click", () => {
    const [from, to] = board.window();
    const moment = `&t=${board.head.toFixed(4)}&w=${(to - from).toFixed(4)}`;
    // Whoever is sent a link may look, also if this page may steer.
    navigator.clipboard?.writeText(`${location.origin}/#${board.described.look}${moment}`);
    history.replaceState(null, "", `#${board.token}${moment}`);
  });
  document.addEventListener("keydown", (event) => {
    if (event.key === " " && event.target === document.body) {
      event.preventDefault();
      element("play").click();
    }
  });
}
