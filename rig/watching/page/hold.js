// A button that counts only while it is held: by a pointer, or by the space bar.

const EVERY = 100; // ms

export class Hold {
  // `beat` is called at once and then again and again, until the button is let go of.
  constructor(button, beat) {
    this.button = button;
    this.beat = beat;
    this.timer = null;
    button.addEventListener("pointerdown", () => this.press());
    button.addEventListener("keydown", (event) => { if (event.key === " ") this.press(); });
    for (const end of ["pointerup", "pointerleave", "pointercancel", "keyup", "blur"]) {
      button.addEventListener(end, () => this.release());
    }
    window.addEventListener("blur", () => this.release());
    document.addEventListener("visibilitychange", () => { if (document.hidden) this.release(); });
    button.addEventListener("contextmenu", (event) => event.preventDefault()); // of a long touch
  }

  get isHeld() {
    return this.timer !== null;
  }

  press() {
    if (this.isHeld) return;
    this.button.classList.add("on");
    this.timer = setInterval(() => this.beat(false), EVERY);
    this.beat(true);
  }

  release() {
    clearInterval(this.timer);
    this.timer = null;
    this.button.classList.remove("on");
  }
}
