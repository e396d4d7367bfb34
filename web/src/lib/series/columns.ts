// Samples as Float64Array columns that share a time column, for live data and recordings. NaN: the channel has no value in that row.
// Columns grow by doubling up to `capacity` rows; then the oldest quarter is dropped in one move, so that a view is always one contiguous
// piece and the cost of a row does not grow.

export type Cell = number | boolean | null;

const FIRST = 4096;

export class Columns {
  /** Rows stored now. */
  length = 0;
  /** Rows dropped from the front so far: `start + i` identifies a row permanently. */
  start = 0;
  /** Seconds that can lie between two rows because the rows are decimated; 0: they are not. */
  spacing = 0;
  private allocated: number;
  private time: Float64Array;
  private readonly byName = new Map<string, Float64Array>();

  constructor(
    private readonly capacity = 1 << 18,
    /** Seconds stored at most. */
    private readonly span = Infinity,
  ) {
    this.allocated = Math.min(FIRST, capacity);
    this.time = new Float64Array(this.allocated);
  }

  get names(): string[] {
    return [...this.byName.keys()];
  }

  get first(): number {
    return this.length ? this.time[0]! : NaN;
  }

  get last(): number {
    return this.length ? this.time[this.length - 1]! : NaN;
  }

  /** A view, valid until the next `append`. */
  times(from = 0, to = this.length): Float64Array {
    return this.time.subarray(from, to);
  }

  /** A view like that of `times`; undefined if the name never occurred. */
  column(name: string, from = 0, to = this.length): Float64Array | undefined {
    return this.byName.get(name)?.subarray(from, to);
  }

  /** Append rows and return how many were added. Rows not later than the last one are skipped, so that a repeated message adds nothing. */
  append(names: readonly string[], times: readonly number[], values: readonly (readonly Cell[])[]): number {
    const last = this.last;
    let skipped = 0;
    while (skipped < times.length && times[skipped]! <= last) skipped += 1;
    // More rows than the capacity: only the last of them.
    const over = Math.max(0, times.length - skipped - this.capacity);
    skipped += over;
    this.start += over;
    const added = times.length - skipped;
    if (added <= 0) return 0;
    this.reserve(added);
    const at = this.length;
    for (let row = 0; row < added; row += 1) this.time[at + row] = times[skipped + row]!;
    for (const name of names) if (!this.byName.has(name)) this.byName.set(name, this.blank(at));
    const given = new Map(names.map((name, index) => [name, values[index]!]));
    for (const [name, column] of this.byName) {
      const cells = given.get(name);
      for (let row = 0; row < added; row += 1) column[at + row] = numeric(cells?.[skipped + row]);
    }
    this.length += added;
    this.dropOld();
    return added;
  }

  /** Move all rows: the program's date was set. */
  move(seconds: number): void {
    for (let row = 0; row < this.length; row += 1) this.time[row]! += seconds;
  }

  clear(): void {
    this.start += this.length;
    this.length = 0;
    this.byName.clear();
  }

  /** The last row not later than `time`; -1 if all are later. */
  rowAt(time: number): number {
    return countWhile(this.length, (row) => this.time[row]! <= time) - 1;
  }

  /** The first row not earlier than `time`; `length` if all are earlier. */
  rowFrom(time: number): number {
    const row = this.rowAt(time);
    return row >= 0 && this.time[row] === time ? row : row + 1;
  }

  /** The last value at or before the row, with its row; undefined if there is none within `reach` seconds. */
  valueAt(name: string, row: number, reach = Infinity): { value: number; row: number } | undefined {
    const column = this.byName.get(name);
    if (!column || row < 0) return undefined;
    const until = this.time[Math.min(row, this.length - 1)]! - reach;
    for (let at = Math.min(row, this.length - 1); at >= 0 && this.time[at]! >= until; at -= 1) {
      const value = column[at]!;
      if (!Number.isNaN(value)) return { value, row: at };
    }
    return undefined;
  }

  private blank(filled: number): Float64Array {
    const column = new Float64Array(this.allocated);
    column.fill(NaN, 0, filled);
    return column;
  }

  private reserve(added: number): void {
    if (this.length + added <= this.allocated) return;
    if (this.allocated < this.capacity) {
      while (this.allocated < this.length + added && this.allocated < this.capacity) this.allocated *= 2;
      this.allocated = Math.min(this.allocated, this.capacity);
      this.time = enlarged(this.time, this.allocated);
      for (const [name, column] of this.byName) this.byName.set(name, enlarged(column, this.allocated));
    }
    if (this.length + added > this.allocated) {
      this.drop(Math.max(this.length + added - this.allocated, this.length >> 2));
    }
  }

  /** Drop rows older than `span`, a quarter at a time. */
  private dropOld(): void {
    if (this.span === Infinity || this.length < FIRST) return;
    const quarter = this.length >> 2;
    if (this.time[quarter]! < this.last - this.span) this.drop(quarter);
  }

  private drop(count: number): void {
    const dropped = Math.min(count, this.length);
    this.time.copyWithin(0, dropped, this.length);
    for (const column of this.byName.values()) column.copyWithin(0, dropped, this.length);
    this.length -= dropped;
    this.start += dropped;
  }
}

/** Of `length` ascending things the first ones that are so, by halving: those that are so come before all others. */
export function countWhile(length: number, isSo: (at: number) => boolean): number {
  let low = 0;
  let high = length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (isSo(middle)) low = middle + 1;
    else high = middle;
  }
  return low;
}

export interface Extremes {
  min: number;
  max: number;
}

/** The lowest and the highest of the numbers; NaN is none. */
export function extremesOf(numbers: Iterable<number>): Extremes | undefined {
  let min = Infinity;
  let max = -Infinity;
  for (const value of numbers) {
    if (value < min) min = value;
    if (value > max) max = value;
  }
  return min <= max ? { min, max } : undefined;
}

const numeric = (cell: Cell | undefined): number => (cell === null || cell === undefined ? NaN : Number(cell));

/** The same numbers in an array with room for `allocated`. */
export function enlarged(column: Float64Array, allocated: number): Float64Array<ArrayBuffer> {
  const bigger = new Float64Array(allocated);
  bigger.set(column);
  return bigger;
}
