// Values of a channel at a time and between two times.
import type { Columns } from "../../../../lib/series/columns";
import { gapThreshold } from "../../../../lib/series/gapThreshold";
import type { LineEvent } from "../../../../lib/api/types";
import { rowsBetween, standing } from "../statistics/statistics";

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

/** The mean between two times, as in the statistics, without their sorting: it is shown while a cursor moves. Null without values. */
export function meanOf(columns: Columns, name: string, from: number, to: number): number | null {
  const [first, last] = rowsBetween(columns, from, to);
  const column = columns.column(name, first, last);
  if (!column) return null;
  const times = columns.times(first, last);
  const gap = gapThreshold(columns, name, first, last);
  let [sum, covered, plain, count] = [0, 0, 0, 0];
  let before = NaN;
  let since = NaN;
  const add = (until: number) => {
    const seconds = standing(until - since, gap);
    sum += before * seconds;
    covered += seconds;
  };
  for (let row = 0; row < column.length; row += 1) {
    const value = column[row]!;
    if (Number.isNaN(value)) continue;
    if (count > 0) add(times[row]!);
    [before, since] = [value, times[row]!];
    plain += value;
    count += 1;
  }
  if (count === 0) return null;
  add(to);
  return covered > 0 ? sum / covered : plain / count;
}
