// The value at a time; null in a gap, or if the last value is too old.
import type { Columns } from "../../../lib/series/columns";
import { gapThreshold } from "../../../lib/series/gapThreshold";
import type { LineEvent } from "../../../lib/api/types";

/** Seconds on each side in which the usual interval is measured. */
const AROUND = 30;

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
