// What stands beside the scope: how the cycles go, and how near the limits are.

import { number } from "./units.js";

const element = (id) => document.getElementById(id);

export function tellCycle(status, isSimulated) {
  const ms = (value) => `${number(value * 1e3, 3)} ms`;
  const facts = {
    rate: `${number(status.rate, 4)} Hz`, cycles: String(status.count),
    missed: String(status.missed),
  };
  if (!isSimulated) { // whose clock is not the wall's
    Object.assign(facts, { "late (p99)": ms(status.late), "least slack": ms(status.slack) });
  }
  element("cycle").replaceChildren(...Object.entries(facts).flatMap(([name, value]) => {
    const [term, told] = [document.createElement("dt"), document.createElement("dd")];
    [term.textContent, told.textContent] = [name, value];
    return [term, told];
  }));
}

export function tellMargins(status, columns) {
  if (!status.margins.length) return;
  element("margins-title").textContent = status.live ? "Nearest limits" : "Nearest limits of the run";
  element("margins").replaceChildren(...status.margins.map(([k, share]) => {
    const row = document.createElement("div");
    const [name, left] = [document.createElement("span"), document.createElement("span")];
    name.textContent = columns[k]?.[0] ?? "";
    left.textContent = `${Math.round(100 * share)} % left`;
    const meter = document.createElement("meter");
    Object.assign(meter, { min: 0, max: 1, low: 0.75, high: 0.9, optimum: 0 });
    meter.value = 1 - Math.max(share, 0);
    row.append(name, left, meter);
    return row;
  }));
}
