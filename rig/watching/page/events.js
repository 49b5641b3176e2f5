// What has happened in the run: a list beside the scope, and marks on the slider.

import { number } from "./units.js";

const MOST = 2000;
const element = (id) => document.getElementById(id);

export class Events {
  // `go` leads to a time; `heard` is told of each event.
  constructor(go, heard) {
    this.go = go;
    this.heard = heard;
    this.all = [];
  }

  add(events) {
    for (const event of events) {
      this.all.push(event);
      element("events").prepend(this.entry(event));
      this.heard(event);
    }
    if (this.all.length <= MOST) return;
    this.all.splice(0, this.all.length - MOST);
    while (element("events").children.length > MOST) element("events").lastChild.remove();
  }

  entry(event) {
    const entry = document.createElement("li");
    entry.className = event.kind;
    const [time, text] = [document.createElement("time"), document.createElement("span")];
    time.textContent = event.t === null ? "–" : `${number(event.t, 4)} s`;
    const isChange = event.kind === "state" || event.kind === "tuning";
    text.textContent = isChange ? event.message.replace("->", "→") : event.message;
    entry.append(time, text);
    entry.addEventListener("click", () => event.t !== null && this.go(event.t));
    return entry;
  }

  clear() {
    this.all = [];
    element("events").replaceChildren();
  }

  // To the next event after a time, or to the one before it.
  step(from, forwards) {
    const times = this.all.map((event) => event.t).filter((t) => t !== null).sort((a, b) => a - b);
    const next = forwards ? times.find((t) => t > from + 1e-6) : times.findLast((t) => t < from - 1e-6);
    if (next !== undefined) this.go(next);
  }

  // On a slider that ends at `last`.
  mark(last) {
    if (!last) return;
    const marks = this.all.filter((event) => event.t !== null).map((event) => {
      const mark = document.createElement("i");
      mark.className = event.kind;
      mark.style.left = `${100 * event.t / last}%`;
      return mark;
    });
    element("marks").replaceChildren(...marks);
  }
}
