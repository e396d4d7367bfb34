// The points of a line between its interruptions.
import type { Cells } from "../../../../lib/series/decimate";

/** Points of time and value; a new piece begins where an interruption lies between two points. */
export function piecesOf(times: readonly number[], cells: Cells, broken: readonly [number, number][]): [number, number][][] {
  const breaks = [...broken].sort((one, other) => one[0] - other[0]);
  const pieces: [number, number][][] = [];
  let last = -Infinity;
  let next = 0;
  for (let row = 0; row < cells.length; row += 1) {
    const value = cells[row];
    const time = times[row]!;
    if (value === null || value === undefined) continue;
    let apart = pieces.length === 0;
    while (next < breaks.length && breaks[next]![0] < time) {
      if (breaks[next]![1] > last) apart = true;
      next += 1;
    }
    if (apart) pieces.push([]);
    pieces[pieces.length - 1]!.push([time, value]);
    last = time;
  }
  return pieces;
}
