// What a table shows: a statistic of one recording, of the reference, or the difference.
import type { Cells, Statistic } from "../../../lib/pairs/cells";
import { extremesOf } from "../../../lib/series/columns";

export type Side = "first" | "second" | "difference";

/** The value of a cell; NaN: none. `second` has the same edges. */
export function valueOf(cell: number, first: Cells, second: Cells | null, side: Side, statistic: Statistic, least: number): number {
  const own = first.value(cell, statistic, least);
  if (side === "first" || !second) return own;
  const other = second.value(cell, statistic, least);
  return side === "second" ? other : own - other;
}

/** The readings of a cell; of a difference: those of the side that has fewer. */
export function countOf(cell: number, first: Cells, second: Cells | null, side: Side): number {
  if (side === "first" || !second) return first.count[cell]!;
  return side === "second" ? second.count[cell]! : Math.min(first.count[cell]!, second.count[cell]!);
}

/** The lowest and highest of the values; of differences: the same to both sides of 0. Null: there are none. */
export function rangeOf(values: readonly number[], side: Side): [number, number] | null {
  const found = extremesOf(values);
  if (!found) return null;
  const most = Math.max(Math.abs(found.min), Math.abs(found.max));
  return side === "difference" ? [-most, most] : [found.min, found.max];
}

/** The columns and rows (from, to before) from the first to the last one with readings; null: there are none. */
export function usedPart(counts: readonly number[], width: number): { left: number; right: number; bottom: number; top: number } | null {
  let [left, right, bottom, top] = [Infinity, 0, Infinity, 0];
  counts.forEach((count, cell) => {
    if (count === 0) return;
    const [column, row] = [cell % width, Math.floor(cell / width)];
    [left, right] = [Math.min(left, column), Math.max(right, column + 1)];
    [bottom, top] = [Math.min(bottom, row), Math.max(top, row + 1)];
  });
  return right > 0 ? { left, right, bottom, top } : null;
}
