// Gains that may be changed while the run goes on; the controller has the last word on each.

import { number } from "./units.js";

export class Gains {
  constructor(link, hardware) {
    this.link = link;
    this.hardware = hardware;
    this.card = document.getElementById("gains-card");
    this.list = document.getElementById("gains");
    this.said = document.getElementById("gain-said");
    this.hold = document.getElementById("hold");
    this.ramp = document.getElementById("ramp");
    this.listen();
  }

  describe(gains, steers, hardware) {
    this.permitted = steers && gains.length > 0;
    this.hold.hidden = !hardware;
    this.hardware = hardware;
    this.rows = new Map();
    this.list.replaceChildren(...gains.map((gain) => this.row(gain)));
  }

  // Of a run that has ended there is nothing to be changed.
  show(live) {
    this.card.hidden = !(live && this.permitted);
  }

  row(gain) {
    const row = document.createElement("div");
    const name = document.createElement("span");
    name.textContent = gain.key;
    const tell = (now) => {
      name.title = `${number(gain.low)} … ${number(gain.high)}; now ${number(now)}`;
    };
    tell(gain.value);
    const value = document.createElement("input");
    value.type = "number";
    value.step = "any";
    value.value = gain.value;
    value.name = gain.key;
    value.ariaLabel = gain.key;
    const set = document.createElement("button");
    const undo = document.createElement("button");
    [set.type, undo.type] = ["button", "button"];
    [set.textContent, undo.textContent] = ["set", "undo"];
    const past = []; // what it was before each change that the loop made
    undo.disabled = true;
    set.addEventListener("click", () => {
      if (value.value !== "") this.send(gain.key, Number(value.value));
    });
    undo.addEventListener("click", () => this.send(gain.key, past[past.length - 1]));
    this.rows.set(gain.key, (change) => {
      if (past.length && change.new === past[past.length - 1]) past.pop();
      else past.push(change.old);
      value.value = change.new;
      undo.disabled = !past.length;
      tell(change.new);
    });
    row.append(name, value, set, undo);
    return row;
  }

  send(key, value, sure = false) {
    this.asked = [key, value];
    this.link.say({ type: "gain", key, value, ramp: Number(this.ramp.value), sure });
  }

  // The loop has the last word: what it changed is what there is to be undone.
  heard(event) {
    if (event.data?.accepted) this.rows.get(event.data.key)?.(event.data);
    this.said.textContent = event.message;
  }

  // What needs to be asked again is asked in the page, not by a dialogue that would cover the stop.
  answer(message) {
    this.said.textContent = message.message;
    if (!message.message.endsWith("?")) return;
    const sure = document.createElement("button");
    sure.type = "button";
    sure.textContent = "yes";
    sure.addEventListener("click", () => this.send(...this.asked, true));
    this.said.append(" ", sure);
  }

  listen() {
    let beat = null;
    const release = () => {
      clearInterval(beat);
      beat = null;
      this.hold.classList.remove("on");
    };
    this.hold.addEventListener("pointerdown", () => {
      this.hold.classList.add("on");
      this.link.say({ type: "hold" });
      beat ??= setInterval(() => this.link.say({ type: "hold" }), 100);
    });
    for (const end of ["pointerup", "pointerleave", "pointercancel"]) {
      this.hold.addEventListener(end, release);
    }
    window.addEventListener("blur", release);
  }
}
