// Values of different channels that belong together. Each measured value of the first channel counts once; the others come from the same row,
// or are their last values if these are not older than `age` seconds and no gap lies between. Nothing is interpolated.
import { countWhile, enlarged, type Columns } from "../series/columns";

/** Another channel of each pair. `needed`: without a value of it the pair is left out. */
export interface Partner {
  name: string;
  needed: boolean;
}

export interface PairPlan {
  /** The channel whose measured values count. */
  name: string;
  partners: readonly Partner[];
  /** Seconds; 0: of the same row only. */
  age: number;
  /** The rows to use, both ends included; null: all. */
  span: readonly [number, number] | null;
}

const FIRST = 4096;

/** Pairs found so far, in the order of time: a time, the value of the first channel and of each partner. NaN: the partner has none. */
export class Pairs {
  length = 0;
  times = new Float64Array(FIRST);
  /** The first channel, then the partners. */
  readonly values: Float64Array[];
  /** Measured values of the first channel that have no needed partner. */
  left = 0;
  /** The lowest and highest of each of `values`; from Infinity to −Infinity: none. */
  readonly low: Float64Array;
  readonly high: Float64Array;
  private readonly last: Float64Array;
  private readonly lastTime: Float64Array;
  /** The next row, counted from the columns' beginning. */
  private next = -1;
  private begin = 0;

  constructor(private readonly plan: PairPlan) {
    const count = plan.partners.length;
    this.values = Array.from({ length: count + 1 }, () => new Float64Array(FIRST));
    this.low = new Float64Array(count + 1).fill(Infinity);
    this.high = new Float64Array(count + 1).fill(-Infinity);
    this.last = new Float64Array(count).fill(NaN);
    this.lastTime = new Float64Array(count).fill(-Infinity);
  }

  /** Whether rows that were paired have been dropped from the columns since, so that these pairs hold more than the columns do. */
  isOutdated(columns: Columns): boolean {
    return this.next >= 0 && columns.start > this.begin;
  }

  /** The share of the rows that has been read, 0 … 1. */
  share(columns: Columns): number {
    if (this.next < 0) return columns.length > 0 ? 0 : 1;
    return columns.length > 0 ? Math.min(1, (this.next - columns.start) / columns.length) : 1;
  }

  /**
   * Read at most `most` further rows. `gaps`: the times at which gaps begin, ascending. Returns whether rows are left; later rows may be
   * appended to the columns and read by another call.
   */
  read(columns: Columns, gaps: readonly number[], most: number): boolean {
    const { span, age, partners } = this.plan;
    if (columns.length === 0) return false;
    if (this.next < 0) this.next = this.begin = columns.start + (span ? columns.rowFrom(span[0]) : 0);
    const first = Math.max(0, this.next - columns.start);
    const end = span ? columns.rowAt(span[1]) + 1 : columns.length;
    const to = Math.min(end, first + most);
    if (to <= first) return false;
    const times = columns.times();
    const own = columns.column(this.plan.name);
    const others = partners.map(({ name }) => columns.column(name));
    this.reserve(to - first);
    let gap = countWhile(gaps.length, (at) => gaps[at]! < times[first]!);
    for (let row = first; row < to; row += 1) {
      const time = times[row]!;
      while (gap < gaps.length && gaps[gap]! < time) gap += 1;
      for (let at = 0; at < others.length; at += 1) {
        const value = others[at]?.[row];
        if (value === undefined || value !== value) continue;
        this.last[at] = value;
        this.lastTime[at] = time;
      }
      const value = own?.[row];
      if (value === undefined || value !== value) continue;
      this.add(time, value, age, gap > 0 ? gaps[gap - 1]! : -Infinity);
    }
    this.next = columns.start + to;
    return to < end;
  }

  /** `broken`: the beginning of the last gap; values measured before it have no successor here. */
  private add(time: number, value: number, age: number, broken: number): void {
    const { partners } = this.plan;
    const at = this.length;
    this.times[at] = time;
    this.values[0]![at] = value;
    for (let index = 0; index < partners.length; index += 1) {
      const measured = this.lastTime[index]!;
      const current = measured === time || (time - measured <= age && measured > broken);
      if (!current && partners[index]!.needed) {
        this.left += 1;
        return;
      }
      this.values[index + 1]![at] = current ? this.last[index]! : NaN;
    }
    this.length += 1;
    for (let index = 0; index < this.values.length; index += 1) {
      const one = this.values[index]![at]!;
      if (one < this.low[index]!) this.low[index] = one;
      if (one > this.high[index]!) this.high[index] = one;
    }
  }

  private reserve(more: number): void {
    if (this.length + more <= this.times.length) return;
    const size = Math.max(this.times.length * 2, this.length + more);
    this.times = enlarged(this.times, size);
    this.values.forEach((array, index) => (this.values[index] = enlarged(array, size)));
  }
}
