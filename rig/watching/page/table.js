// Rows of some columns, in the order of their time; the oldest are forgotten.

const MOST = 120_000;

export class Table {
  constructor(columns) {
    this.columns = columns;
    this.place = new Map(columns.map((column, k) => [column, k]));
    this.count = 0;
    this.reserve(4096);
  }

  reserve(room) {
    const t = new Float64Array(room);
    if (this.count) t.set(this.t.subarray(0, this.count));
    const values = this.columns.map((_, k) => {
      const grown = new Float32Array(room);
      if (this.count) grown.set(this.values[k].subarray(0, this.count));
      return grown;
    });
    this.t = t;
    this.values = values;
  }

  add(block) {
    if (this.count + block.count > MOST) this.forget(this.count - MOST / 2);
    if (this.count + block.count > this.t.length) {
      this.reserve(Math.max(2 * this.t.length, this.count + block.count));
    }
    for (let row = 0; row < block.count; row += 1) {
      const from = row * block.stride;
      const to = this.count + row;
      this.t[to] = block.origin + block.values[from];
      for (let k = 0; k < this.values.length; k += 1) {
        this.values[k][to] = block.values[from + 1 + k];
      }
    }
    this.count += block.count;
  }

  forget(rows) {
    if (rows <= 0) return;
    this.t.copyWithin(0, rows, this.count);
    for (const column of this.values) column.copyWithin(0, rows, this.count);
    this.count -= rows;
  }

  // Number of the first row that is not before a time.
  rowAt(t) {
    let low = 0;
    let high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.t[middle] < t) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  // The row that is nearest to a time; -1 if there is none.
  nearest(t) {
    const row = this.rowAt(t);
    if (!this.count) return -1;
    if (row === this.count) return row - 1;
    return row > 0 && t - this.t[row - 1] < this.t[row] - t ? row - 1 : row;
  }

  get last() {
    return this.count ? this.t[this.count - 1] : 0;
  }
}
