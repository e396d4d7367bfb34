// How far apart two values of a channel may lie and still be mergeTimelines: a few of its own usual distances, as far as the window shows them. What
// lies longer without a value is a hole, and is drawn as one.
import type { Columns } from "./columns";

/** With too few values to tell a usual distance. */
const DEFAULT_SECONDS = 3;
/** What the line's own hiccups may take, however fast it is. */
const MIN_SECONDS = 0.5;
const INTERVALS = 5;
const SAMPLES = 128;
/** Rows looked through for the value before. */
const MAX_ROWS_BACK = 2000;

/** Seconds, for the rows from `first` to before `last`. */
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
  // Most of them, not the middle one: how often it is asked may have changed within the window.
  found.sort((one, other) => one - other);
  return Math.max(MIN_SECONDS, INTERVALS * found[Math.floor((found.length - 1) * 0.8)]!, columns.spacing);
}

/** The row of the last value not after that one; -1: none near. */
function lastValueRow(column: Float64Array, row: number): number {
  for (let at = row; at >= 0 && at > row - MAX_ROWS_BACK; at -= 1) if (!Number.isNaN(column[at]!)) return at;
  return -1;
}
