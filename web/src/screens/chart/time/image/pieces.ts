// The points of a line between its interruptions.
import type { Cells } from "../../../../lib/series/decimate";

type Point = [number, number];

/**
 * Points of time and value; a new piece begins where an interruption lies between two points. The points of a line that stands still were
 * left out (`decimate`), so between two equal values it goes up to the interruption, and on behind it.
 */
export function piecesOf(times: readonly number[], cells: Cells, broken: readonly [number, number][]): Point[][] {
  const breaks = united(broken);
  const pieces: Point[][] = [];
  let piece: Point[] = [];
  let next = 0;
  for (let row = 0; row < cells.length; row += 1) {
    const value = cells[row];
    const time = times[row]!;
    if (value === null || value === undefined) continue;
    if (pieces.length === 0) pieces.push(piece);
    for (; next < breaks.length && breaks[next]![0] < time; next += 1) {
      const [begin, end] = breaks[next]!;
      const last = piece[piece.length - 1];
      if (!last || end <= last[0]) continue;
      const still = last[1] === value;
      if (still && begin > last[0]) piece.push([begin, value]);
      pieces.push((piece = still && end < time ? [[end, value]] : []));
    }
    piece.push([time, value]);
  }
  return pieces;
}

/** In the order of time, those that overlap as one. */
function united(broken: readonly [number, number][]): [number, number][] {
  const breaks: [number, number][] = [];
  for (const [begin, end] of [...broken].sort((one, other) => one[0] - other[0])) {
    const last = breaks[breaks.length - 1];
    if (last && begin <= last[1]) last[1] = Math.max(last[1], end);
    else breaks.push([begin, end]);
  }
  return breaks;
}
