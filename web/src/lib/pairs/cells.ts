// Statistics of a channel in the cells of a table, added up pair by pair (Welford: exact also for long recordings with a small spread).
import { binOf } from "./bins";
import type { Pairs } from "./pairs";

export const STATISTICS = ["mean", "count", "min", "max", "deviation"] as const;
export type Statistic = (typeof STATISTICS)[number];

/** `values[0]` of the pairs is counted in cells by `values[1]` (columns) and `values[2]` (rows). */
export class Cells {
  /** Pairs read so far, and those among them in no cell. */
  taken = 0;
  outside = 0;
  readonly width: number;
  readonly height: number;
  readonly count: Float64Array;
  private readonly mean: Float64Array;
  private readonly squares: Float64Array;
  private readonly min: Float64Array;
  private readonly max: Float64Array;

  constructor(
    readonly columns: readonly number[],
    readonly rows: readonly number[],
  ) {
    this.width = columns.length - 1;
    this.height = rows.length - 1;
    const size = this.width * this.height;
    this.count = new Float64Array(size);
    this.mean = new Float64Array(size);
    this.squares = new Float64Array(size);
    this.min = new Float64Array(size).fill(Infinity);
    this.max = new Float64Array(size).fill(-Infinity);
  }

  /** The cell of the two values; -1: outside. */
  cellOf(x: number, y: number): number {
    const column = binOf(this.columns, x);
    const row = column < 0 ? -1 : binOf(this.rows, y);
    return row < 0 ? -1 : row * this.width + column;
  }

  /** Add at most `most` further pairs. Returns whether pairs are left. */
  take(pairs: Pairs, most: number): boolean {
    const [values, x, y] = [pairs.values[0]!, pairs.values[1]!, pairs.values[2]!];
    const to = Math.min(pairs.length, this.taken + most);
    for (let at = this.taken; at < to; at += 1) {
      const cell = this.cellOf(x[at]!, y[at]!);
      if (cell < 0) this.outside += 1;
      else this.add(cell, values[at]!);
    }
    this.taken = to;
    return to < pairs.length;
  }

  /** NaN: the cell has no value, or fewer than `least`; of the standard deviation (of a sample): fewer than two. A count is always a number. */
  value(cell: number, statistic: Statistic, least: number): number {
    const count = this.count[cell]!;
    if (statistic === "count") return count;
    if (count === 0 || count < least) return NaN;
    if (statistic === "mean") return this.mean[cell]!;
    if (statistic === "min") return this.min[cell]!;
    if (statistic === "max") return this.max[cell]!;
    return count < 2 ? NaN : Math.sqrt(this.squares[cell]! / (count - 1));
  }

  /** The numbers of the pairs in a cell, ascending. */
  pairsIn(cell: number, pairs: Pairs): number[] {
    const [x, y] = [pairs.values[1]!, pairs.values[2]!];
    const found: number[] = [];
    for (let at = 0; at < this.taken; at += 1) if (this.cellOf(x[at]!, y[at]!) === cell) found.push(at);
    return found;
  }

  private add(cell: number, value: number): void {
    const count = this.count[cell]! + 1;
    const away = value - this.mean[cell]!;
    const mean = this.mean[cell]! + away / count;
    this.count[cell] = count;
    this.mean[cell] = mean;
    this.squares[cell] = this.squares[cell]! + away * (value - mean);
    if (value < this.min[cell]!) this.min[cell] = value;
    if (value > this.max[cell]!) this.max[cell] = value;
  }
}
