// A grid over the block: the nearest point, and points that stand for their cells.

class PointGrid {
  constructor(east, north, extent) {
    const [west, south, right, top] = extent;
    const n = east.length, area = Math.max(right - west, 1) * Math.max(top - south, 1);
    const longest = Math.max(right - west, top - south, 1);
    this.cell = Math.max(Math.sqrt((area * 3) / Math.max(n, 1)), longest / 2000);
    this.west = west;
    this.south = south;
    this.nx = Math.floor((right - west) / this.cell) + 1;
    this.ny = Math.floor((top - south) / this.cell) + 1;
    this.east = east;
    this.north = north;
    this._fill(n);
  }

  _column(east) {
    return Math.min(Math.max(Math.floor((east - this.west) / this.cell), 0), this.nx - 1);
  }

  _row(north) {
    return Math.min(Math.max(Math.floor((north - this.south) / this.cell), 0), this.ny - 1);
  }

  _fill(n) {
    this.starts = new Uint32Array(this.nx * this.ny + 1);
    const cells = new Int32Array(n).fill(-1);
    for (let i = 0; i < n; i++) {
      if (!isNumber(this.east[i]) || !isNumber(this.north[i])) continue;
      cells[i] = this._row(this.north[i]) * this.nx + this._column(this.east[i]);
      this.starts[cells[i] + 1]++;
    }
    for (let c = 0; c < this.nx * this.ny; c++) this.starts[c + 1] += this.starts[c];
    const next = this.starts.slice();
    this.items = new Uint32Array(this.starts[this.nx * this.ny]);
    for (let i = 0; i < n; i++) if (cells[i] >= 0) this.items[next[cells[i]]++] = i;
  }

  /** The nearest point within a distance [m] that is shown, or -1. */
  nearest(east, north, reach, isShown) {
    let best = -1, least = reach * reach;
    const right = this._column(east + reach), top = this._row(north + reach);
    for (let row = this._row(north - reach); row <= top; row++) {
      for (let column = this._column(east - reach); column <= right; column++) {
        const cell = row * this.nx + column;
        for (let k = this.starts[cell]; k < this.starts[cell + 1]; k++) {
          const i = this.items[k];
          const square = (this.east[i] - east) ** 2 + (this.north[i] - north) ** 2;
          if (square < least && isShown(i)) { least = square; best = i; }
        }
      }
    }
    return best;
  }

  /** One of each cell of so many metres, of some points. */
  thinned(metres, rows) {
    const nx = Math.floor((this.nx * this.cell) / metres) + 1;
    const ny = Math.floor((this.ny * this.cell) / metres) + 1;
    const taken = nx * ny < 8e6 ? new Uint8Array(nx * ny) : null, seen = new Set();
    const found = [];
    for (const i of rows) {
      const column = Math.floor((this.east[i] - this.west) / metres);
      const key = Math.floor((this.north[i] - this.south) / metres) * nx + column;
      if (taken ? taken[key] : seen.has(key)) continue;
      if (taken) taken[key] = 1; else seen.add(key);
      found.push(i);
    }
    return Uint32Array.from(found);
  }
}
