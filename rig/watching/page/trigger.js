// What holds the page still: a level that the first channel of a pane crosses, or is beyond.

const WAYS = {
  "↕": ["when it crosses", (a, b, level) => a < level !== b < level],
  "↑": ["when it rises through", (a, b, level) => a < level && b >= level],
  "↓": ["when it falls through", (a, b, level) => a >= level && b < level],
  ">": ["while it is above", (a, b, level) => b > level],
  "<": ["while it is below", (a, b, level) => b < level],
};

export class Trigger {
  constructor(level, way = "↕") {
    this.level = level;
    this.way = way;
  }

  get title() {
    return WAYS[this.way][0];
  }

  fires(before, now) {
    return WAYS[this.way][1](before, now, this.level);
  }

  // The same level in the next way; null after the last one.
  get next() {
    const ways = Object.keys(WAYS);
    const way = ways[ways.indexOf(this.way) + 1];
    return way ? new Trigger(this.level, way) : null;
  }
}
