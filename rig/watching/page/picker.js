// Which channels a pane shows: a list to be searched, those with a star first.

import { Favourites } from "./favourites.js";

const element = (id) => document.getElementById(id);

export class Picker {
  constructor(board) {
    this.board = board;
  }

  open(pane) {
    const list = element("found");
    const favourites = new Favourites(this.board.described.rig);
    const show = () => {
      const wanted = element("search").value.toLowerCase();
      const found = this.board.columns.map((column, k) => [column, k])
        .filter(([column]) => `${column[0]} ${column[2]}`.toLowerCase().includes(wanted));
      const ordered = [true, false].flatMap((first) => (
        found.filter(([column]) => favourites.has(column[0]) === first)
      ));
      list.replaceChildren(...ordered.map(([column, k]) => {
        const entry = this.choice(pane, column, k);
        entry.append(favourites.star(column[0], show));
        return entry;
      }));
    };
    element("picker-title").textContent = `Channels of ${pane.title}`;
    element("search").oninput = show;
    element("search").value = "";
    show();
    element("picker").show(); // not modal: a modal one would lie over the stop
  }

  choice(pane, column, k) {
    const entry = document.createElement("li");
    const label = document.createElement("label");
    const box = document.createElement("input");
    box.type = "checkbox";
    box.checked = pane.columns.includes(k);
    box.name = column[0];
    box.addEventListener("change", () => {
      pane.columns = box.checked ? [...pane.columns, k] : pane.columns.filter((one) => one !== k);
      pane.list();
      this.board.rows.subscribe();
    });
    const text = document.createElement("small");
    text.textContent = `${column[2]}${column[1] ? ` [${column[1]}]` : ""}`;
    label.append(box, column[0], text);
    entry.append(label);
    return entry;
  }
}
