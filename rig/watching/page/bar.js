// The bar over the page: which run it is, whether it moves anything, and how old its data are.

import { seconds } from "./units.js";

const PHASES = { "-1": "–", 0: "approach", 1: "run", 2: "stop" };
const OLD = 1.0; // s; older data are marked
const REFUSED = 4401;
const element = (id) => document.getElementById(id);

// A simulation and hardware are told apart by colour, title and the mark in every picture.
export function tellRun(told, mark) {
  document.documentElement.classList.toggle("hardware", !told.simulated);
  document.title = `${mark} · ${told.experiment} · rig`;
  element("kind").textContent = mark;
  element("title").textContent = told.experiment;
  const seed = told.seed === null ? "" : `, seed ${told.seed}`;
  const beside = told.beside ? ` · beside ${told.beside}` : "";
  element("subtitle").textContent =
    `${told.rig} · ${told.law} · ${told.backend}${seed} · ${told.run}${beside}`;
}

export function tellState(status) {
  element("phase").textContent = status.live ? PHASES[status.phase] ?? "–" : status.state;
  element("phase").title = status.message ?? "";
  element("time").textContent = status.count ? seconds(status.t) : "–";
  element("live").hidden = !status.live;
  element("slider").max = status.t || 1;
}

// `since` is how long ago the server has said so, s.
export function tellAge(status, since) {
  const age = status.live ? status.age + Math.max(since, 0) : 0;
  element("age").textContent = status.live ? `${age.toFixed(1)} s old` : "complete";
  element("age").className = age > OLD ? "old" : "";
}

export function tellLoss(code) {
  element("age").textContent = code === REFUSED ? "refused" : "no server";
  element("age").className = "old";
  if (code === REFUSED) {
    element("subtitle").textContent = "The token of this address is not the server's. Stop works.";
  }
}

export function tellMoment(moment) {
  const slider = element("slider");
  if (document.activeElement !== slider || moment.isPlaying || moment.isLive) {
    slider.value = moment.head;
  }
  element("moment").textContent = seconds(moment.head);
  element("play").textContent = moment.isPlaying || moment.isLive ? "❚❚" : "▶";
}
