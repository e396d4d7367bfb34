// Values of a channel at a time and between two times.
import type { Columns } from "../../../../lib/series/columns";
import { gapThreshold } from "../../../../lib/series/gapThreshold";
import type { LineEvent } from "../../../../lib/api/types";

/** Seconds on each side in which the usual interval is measured. */
const AROUND = 30;

/** The value at a time; null in a gap, or if the last value is too old. */
export function valueAt(columns: Columns, events: readonly LineEvent[], name: string, time: number): number | null {
  const reach = gapThreshold(columns, name, Math.max(0, columns.rowAt(time - AROUND)), columns.rowAt(time + AROUND) + 1);
  const found = columns.valueAt(name, columns.rowAt(time), reach);
  if (!found) return null;
  const measured = columns.times(found.row, found.row + 1)[0]!;
  if (time - measured > reach) return null;
  const broken = events.some(
    (event) => event.kind === "gap" && event.began >= measured && event.began < time && (event.ended === null || event.ended > time),
  );
  return broken ? null : found.value;
}

/** The mean of the values between two times; null without values. */
export function meanOf(columns: Columns, name: string, from: number, to: number): number | null {
  const column = columns.column(name, columns.rowAt(from) + 1, columns.rowAt(to) + 1);
  let sum = 0;
  let count = 0;
  for (const value of column ?? []) {
    if (Number.isNaN(value)) continue;
    sum += value;
    count += 1;
  }
  return count > 0 ? sum / count : null;
}
