// What a person does: the transport at the foot of the page, layouts, links, the space bar.

import { layout } from "./layouts.js";
import { Pane } from "./scope.js";

const TOLD = 1500; // ms, for which a button says what came of it
const element = (id) => document.getElementById(id);

function answer(name, text) {
  const button = element(name);
  const usual = button.dataset.usual ??= button.textContent;
  button.textContent = text;
  setTimeout(() => { button.textContent = usual; }, TOLD);
}

// What the buttons and keys of the page do; nothing while there is no server.
export function listen(board) {
  const { moment, events } = board;
  const on = (name, kind, act) => {
    element(name).addEventListener(kind, () => { if (board.status && (moment.isLive || moment.still)) act(); });
  };
  on("live", "click", () => board.follow());
  on("play", "click", () => moment.play());
  on("slider", "input", () => {
    if (moment.isLive) moment.hold(0, moment.last ?? 0);
    moment.head = Number(element("slider").value);
    const [from, to] = moment.still;
    if (moment.head < from || moment.head > to) {
      moment.hold(moment.head - 0.5 * (to - from), moment.head + 0.5 * (to - from));
    }
  });
  on("window", "change", () => {
    const span = Number(element("window").value);
    if (moment.isLive && span) moment.span = span;
    else if (!span) moment.hold(0, moment.last ?? 0);
    else moment.hold(moment.head - 0.7 * span, moment.head + 0.3 * span);
  });
  on("earlier", "click", () => events.step(moment.head, false));
  on("later", "click", () => events.step(moment.head, true));
  const arrange = (name, act) => {
    element(name).addEventListener("click", () => { if (board.described) act(); });
  };
  arrange("add", () => {
    const pane = new Pane(board, { title: `pane ${board.panes.length + 1}`, columns: [] });
    board.panes.push(pane);
    element("panes").append(pane.element);
    board.picker.open(pane);
  });
  arrange("save", () => {
    const kept = board.panes.map((pane) => ({
      title: pane.title, xy: pane.isXY, names: pane.columns.map((k) => board.columns[k][0]),
    }));
    localStorage.setItem(board.key, JSON.stringify(kept));
    answer("save", "layout kept");
  });
  arrange("reset", () => {
    localStorage.removeItem(board.key);
    board.lay(layout(board));
  });
  arrange("link", () => {
    const [from, to] = moment.window;
    const place = `&t=${moment.head.toFixed(4)}&w=${(to - from).toFixed(4)}`;
    // Whoever is sent a link may look, also if this page may steer.
    const copied = navigator.clipboard?.writeText(`${location.origin}/#${board.described.look}${place}`);
    history.replaceState(null, "", `#${board.token}${place}`);
    const isRefused = () => answer("link", "not copied");
    if (copied) copied.then(() => answer("link", "copied"), isRefused);
    else isRefused();
  });
  document.addEventListener("keydown", (event) => {
    if (event.key === " " && event.target === document.body) {
      event.preventDefault();
      element("play").click();
    }
  });
}
