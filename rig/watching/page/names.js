// What channels are called in a pane.

export const PLANNED = /^(reference|plan|applied|command)\./;
const SHORT = { reference: " ref", plan: "", applied: " sent", command: " asked" };

// Names as short as they can be told apart: without the group, and without what all begin with.
export function brief(columns) {
  const bare = columns.map(([k, name]) => [k, name, name.replace(/^[^.]*\./, "").split("_")]);
  let same = 0;
  const [, , first] = bare[0] ?? [0, "", []];
  const different = new Set(bare.map(([, , words]) => words.join("_"))).size > 1;
  while (different && bare.every(([, , words]) => words.length > same + 1 && words[same] === first[same])) {
    same += 1;
  }
  const told = bare.map(([k, name, words]) => {
    const group = PLANNED.exec(name);
    const text = words.slice(same).join(" ");
    return [k, name, group ? `${text}${SHORT[group[1]]}` : text];
  });
  return new Map(told.map(([k, name, text]) => {
    const isTwice = told.some(([other, , like]) => other !== k && like === text);
    return [k, isTwice ? `${text}, ${name.replace(/\..*/, "")}` : text];
  }));
}
