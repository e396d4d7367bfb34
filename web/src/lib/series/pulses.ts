// How often a flag was set, and how long ago: a knock is shown for an eighth of a second, too short to be seen.
import type { Columns } from "./columns";

/** Seconds for which a flag that means trouble is still shown after it was set, as the program's alarms (sampling/alarms.py). */
export const FLAG_HOLD = 3;

export interface Pulses {
  /** How often the flag became set. */
  count: number;
  /** When it was set last; null: never. */
  last: number | null;
  /** The rows are decimated: it may have been more often. */
  atLeast: boolean;
}

/** Counts in columns that grow at their end: each row once. */
export class PulseCounter {
  private count = 0;
  private last: number | null = null;
  private isSet = false;
  /** The row after those counted, by its permanent number. */
  private next = 0;

  /** `from`: earlier rows do not count. */
  constructor(private readonly from = -Infinity) {}

  read(columns: Columns, name: string): Pulses {
    const first = Math.max(0, this.next - columns.start);
    const times = columns.times(first);
    columns.column(name, first)?.forEach((value, row) => {
      const time = times[row]!;
      if (Number.isNaN(value) || time < this.from) return;
      if (value && !this.isSet) this.count += 1;
      if (value) this.last = time;
      this.isSet = value !== 0;
    });
    this.next = columns.start + columns.length;
    return { count: this.count, last: this.last, atLeast: columns.spacing > 0 };
  }
}

/** Seconds since the flag was last set before `now`; null: longer ago than `FLAG_HOLD`, or never. */
export function sinceSet(columns: Columns, name: string, now: number): number | null {
  const column = columns.column(name);
  if (!column) return null;
  const times = columns.times();
  for (let row = columns.rowAt(now); row >= 0 && now - times[row]! < FLAG_HOLD; row -= 1) if (column[row]! > 0) return now - times[row]!;
  return null;
}
