// What a pane shows as a file: CSV, in SI.

export function save(board, pane) {
  const [from, to] = board.moment.window;
  const table = board.rows.table;
  const head = ["t [s]", ...pane.columns.map((k) => `${board.columns[k][0]} [${board.columns[k][1]}]`)];
  const lines = [head.map((name) => `"${name.replaceAll('"', '""')}"`).join(",")];
  for (let row = table.rowAt(from); row < table.rowAt(to); row += 1) {
    const values = pane.columns.map((k) => table.values[table.place.get(k)][row]);
    lines.push([table.t[row], ...values].join(","));
  }
  const address = URL.createObjectURL(new Blob([`${lines.join("\n")}\n`], { type: "text/csv" }));
  const anchor = document.createElement("a");
  anchor.href = address;
  anchor.download = `${board.described.run}-${pane.title}.csv`;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}
