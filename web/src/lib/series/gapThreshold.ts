// How long a channel may be without a value before the line is interrupted: a few of its usual intervals, measured in the visible rows.
import type { Columns } from "./columns";

/** With too few values to measure the interval. */
const DEFAULT_SECONDS = 3;
/** Short pauses of the line never count as gaps. */
const MIN_SECONDS = 0.5;
const INTERVALS = 5;
const SAMPLES = 128;
/** Rows searched for the previous value. */
const MAX_ROWS_BACK = 2000;

/** Seconds, measured in the rows from `first` to before `last`. */
export function gapThreshold(columns: Columns, name: string, first = 0, last = columns.length): number {
  const times = columns.times(first, last);
  const column = columns.column(name, first, last);
  if (!column) return Math.max(DEFAULT_SECONDS, columns.spacing);
  const found: number[] = [];
  const stride = Math.max(1, Math.floor(column.length / SAMPLES));
  for (let row = column.length - 1; row > 0; row -= stride) {
    const later = lastValueRow(column, row);
    const before = later > 0 ? lastValueRow(column, later - 1) : -1;
    if (before < 0) continue;
    found.push(times[later]! - times[before]!);
  }
  if (found.length < 3) return Math.max(DEFAULT_SECONDS, columns.spacing);
  // The 80 % quantile, not the median: the sampling rate can change within the window.
  found.sort((one, other) => one - other);
  return Math.max(MIN_SECONDS, INTERVALS * found[Math.floor((found.length - 1) * 0.8)]!, columns.spacing);
}

/** The row of the last value at or before `row`; -1 if there is none near. */
function lastValueRow(column: Float64Array, row: number): number {
  for (let at = row; at >= 0 && at > row - MAX_ROWS_BACK; at -= 1) if (!Number.isNaN(column[at]!)) return at;
  return -1;
}
