// Which panes there are at first.

// The panes that were kept for this rig, or those that it brings, or a guess.
export function layout(board) {
  const names = new Map(board.columns.map((column, k) => [column[0], k]));
  try {
    const kept = JSON.parse(localStorage.getItem(board.key));
    if (Array.isArray(kept)) {
      return kept.map((pane) => ({
        title: String(pane.title),
        xy: pane.xy === true,
        columns: pane.names.filter((name) => names.has(name)).map((name) => names.get(name)),
      }));
    }
  } catch { /* whatever was kept is of another version: the rig's own panes will do */ }
  const brought = (board.described.scene.panes ?? []).filter((pane) => pane.columns.length);
  if (brought.length) return brought.slice(0, innerWidth < 900 ? 3 : 4);
  return guess(names);
}

// Of a mechanism that says nothing: readings that have a reference, or the first readings.
function guess(names) {
  const found = [];
  for (const [name, k] of names) {
    const wanted = names.get(name.replace(/^reading\./, "reference."));
    if (name.startsWith("reading.") && wanted !== undefined) {
      found.push({ title: name.slice(8), columns: [k, wanted] });
    }
  }
  const first = [...names].filter(([name]) => name.startsWith("reading."));
  const rest = first.map(([name, k]) => ({ title: name.slice(8), columns: [k] }));
  return (found.length ? found : rest).slice(0, 4);
}
