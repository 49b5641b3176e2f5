// Gains that may be changed while the run goes on; the controller has the last word on each.

import { Hold } from "./hold.js";
import { number } from "./units.js";

const element = (id) => document.getElementById(id);

export class Gains {
  constructor(link) {
    this.link = link;
    this.said = element("gain-said");
    this.needsHold = false;
    this.waiting = null; // a change that is made once somebody holds on
    this.hold = new Hold(element("hold"), (isFirst) => {
      link.say({ type: "hold" });
      if (isFirst && this.waiting) this.send(...this.waiting);
    });
  }

  describe(gains, steers, hardware) {
    this.permitted = steers && gains.length > 0;
    this.needsHold = hardware;
    element("hold").hidden = !hardware;
    this.rows = new Map();
    element("gains").replaceChildren(...gains.map((gain) => this.row(gain)));
  }

  // Of a run that has ended there is nothing to be changed.
  show(live) {
    element("gains-card").hidden = !(live && this.permitted);
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
      else if (past[past.length - 1] !== change.old) past.push(change.old); // a ramp that was let go of is one change
      value.value = change.new;
      undo.disabled = !past.length;
      tell(change.new);
    });
    row.append(name, value, set, undo);
    return row;
  }

  // One hand cannot hold on and press another button: a change waits for who holds on.
  send(key, value, sure = false) {
    this.asked = [key, value];
    if (this.needsHold && !this.hold.isHeld) {
      this.waiting = [key, value, sure];
      this.tell(`${key} to ${number(value)}: hold to steer`);
      return;
    }
    this.waiting = null;
    this.link.say({ type: "gain", key, value, ramp: Number(element("ramp").value), sure });
  }

  tell(text) {
    this.said.textContent = text;
  }

  // The loop has the last word: what it changed is what there is to be undone.
  heard(event) {
    if (event.data?.accepted) this.rows.get(event.data.key)?.(event.data);
    this.tell(event.message);
  }

  // What needs to be asked again is asked in the page, not by a dialogue that would cover the stop.
  answer(message) {
    this.tell(message.message);
    if (!message.message.endsWith("?")) return;
    const sure = document.createElement("button");
    sure.type = "button";
    sure.textContent = "yes";
    sure.addEventListener("click", () => this.send(...this.asked, true));
    this.said.append(" ", sure);
  }
}
