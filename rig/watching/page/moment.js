// Which moment is shown, and the window of time around it.

const LONGEST = 60; // s of the past that a page which follows the run can show
const LEAST = 0.05; // s; a shorter window is not followed
const element = (id) => document.getElementById(id);

export class Moment {
  // `held` is called whenever the page holds still at another window.
  constructor(held) {
    this.held = held;
    this.isLive = false;
    this.isPlaying = false;
    this.head = 0; // s, what is shown
    this.span = 10; // s, of the window while the run is followed
    this.still = null; // the window while it does not move: [from, to]
    this.last = null; // s, the newest row; null: there is none
  }

  get window() {
    return this.still ?? [this.head - this.span, this.head];
  }

  follow() {
    this.isLive = true;
    this.isPlaying = false;
    this.still = null;
    this.head = this.last ?? 0;
    element("live").classList.add("on");
    this.tellWidth();
  }

  hold(from, to) {
    this.isLive = false;
    this.still = [from, Math.max(to, from + 1e-3)];
    this.head = Math.min(Math.max(this.head, from), to);
    element("live").classList.remove("on");
    this.tellWidth();
    this.held();
  }

  // To where a link leads.
  goTo(asked) {
    const [t, w] = [Number(asked.get("t")), Number(asked.get("w") || 10)];
    if (!Number.isFinite(t) || !(w > 0)) return;
    this.hold(t - w / 2, t + w / 2);
    this.head = t;
  }

  jump(t) {
    const [from, to] = this.window;
    if (this.isLive || t < from || t > to) {
      const width = this.isLive ? Math.max(this.span, 10) : Math.min(to - from, 1e3);
      this.hold(t - width, t + 0.1 * width); // what came before it is what one wants to see
    }
    this.head = t;
  }

  pan(by) {
    const [from, to] = this.window;
    this.hold(from + by, to + by);
  }

  zoom(factor, about) {
    if (this.isLive) {
      this.span = Math.min(Math.max(this.span * factor, LEAST), LONGEST);
      this.tellWidth();
      return;
    }
    const [from, to] = this.window;
    this.hold(about - (about - from) * factor, about + (to - about) * factor);
  }

  play() {
    if (this.isLive) {
      this.hold(...this.window);
      return;
    }
    this.isPlaying = !this.isPlaying;
    if (this.isPlaying && this.head >= (this.last ?? Infinity)) this.head = Math.max(this.still[0], 0);
  }

  // Go on by some seconds; `newest` is the last row that is here, and a run `grows` or has ended.
  advance(passed, newest, grows) {
    if (this.isLive) {
      const behind = Math.max(newest, this.last ?? 0) - this.head;
      this.head += behind > 2 ? behind : behind * (1 - Math.exp(-passed / 0.15));
      return;
    }
    if (!this.isPlaying || this.last === null) return;
    this.head += passed * Number(element("speed").value);
    if (this.head >= this.last) {
      this.head = this.last;
      this.isPlaying = grows;
    }
    const [from, to] = this.still;
    if (this.head > to) this.hold(this.head - 0.1 * (to - from), this.head + 0.9 * (to - from));
  }

  // The choice of windows says how wide the one that is shown is, whatever has made it so.
  tellWidth() {
    const [from, to] = this.window;
    const isWhole = this.still !== null && from <= 0 && to >= (this.last ?? Infinity);
    const [choice, width] = [element("window"), element("width")];
    const given = [...choice.options].find((one) => Math.abs(Number(one.value) / (to - from) - 1) < 1e-6);
    width.textContent = `${Number((to - from).toPrecision(2))} s`;
    choice.value = isWhole ? "0" : given?.value ?? width.value;
  }
}
