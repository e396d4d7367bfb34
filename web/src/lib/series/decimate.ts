// Reduce columns to what a chart of a given width draws. Up to two rows a pixel: all rows. More: minimum and maximum of each bucket in the
// order of their times, so that no spike is lost. Buckets lie on a fixed grid of time, so that the drawing does not flicker while the
// window moves.
import type { Columns } from "./columns";

export type Cells = (number | null | undefined)[];

export interface Decimated {
  times: number[];
  /** One list for each name; null: no value; undefined: no point needed, the line passes straight. */
  values: Cells[];
  /** Seconds of a bucket; 0: all rows are present. */
  width: number;
}

export function decimate(columns: Columns, names: readonly string[], from: number, to: number, pixels: number): Decimated {
  // One row more on each side, so that the line continues to the edge.
  const first = Math.max(0, columns.rowAt(from));
  const last = Math.min(columns.length, columns.rowAt(to) + 2);
  const times = columns.times(first, last);
  if (times.length <= 2 * pixels || !(to > from)) {
    return {
      times: [...times],
      values: names.map((name) => dropFlatPoints(allRows(columns.column(name, first, last), times.length))),
      width: 0,
    };
  }
  const width = (to - from) / pixels;
  const grid = bucketsOf(times, width);
  return {
    times: grid.numbers.flatMap((number) => [(number + 0.25) * width, (number + 0.75) * width]),
    values: names.map((name) => dropFlatPoints(minMax(columns.column(name, first, last), grid.edges))),
    width,
  };
}

function allRows(column: Float64Array | undefined, length: number): (number | null)[] {
  if (!column) return new Array<null>(length).fill(null);
  return Array.from(column, (value) => (Number.isNaN(value) ? null : value));
}

/** Rows at each end that are never removed: some lie outside the window, and the scale needs values inside. */
const EDGE_ROWS = 4;

/** Remove inner points of flat stretches: most channels are constant for many rows, and each point costs time. */
function dropFlatPoints(values: (number | null)[]): Cells {
  const out: Cells = values;
  let before: number | null = null;
  for (let row = EDGE_ROWS - 1; row + EDGE_ROWS < values.length; row += 1) {
    const value = values[row]!;
    if (row >= EDGE_ROWS && value !== null && value === before && value === values[row + 1]) out[row] = undefined;
    before = value;
  }
  return out;
}

/** Buckets that contain rows: their numbers on the grid and the first row of each (and the end of the last). */
function bucketsOf(times: Float64Array, width: number): { numbers: number[]; edges: number[] } {
  const numbers: number[] = [];
  const edges: number[] = [];
  for (let row = 0; row < times.length; row += 1) {
    const number = Math.floor(times[row]! / width);
    if (number === numbers[numbers.length - 1]) continue;
    numbers.push(number);
    edges.push(row);
  }
  edges.push(times.length);
  return { numbers, edges };
}

function minMax(column: Float64Array | undefined, edges: readonly number[]): (number | null)[] {
  const out = new Array<number | null>(2 * (edges.length - 1)).fill(null);
  if (!column) return out;
  for (let stretch = 0; stretch + 1 < edges.length; stretch += 1) {
    let low = Infinity;
    let high = -Infinity;
    let lowAt = -1;
    let highAt = -1;
    for (let row = edges[stretch]!; row < edges[stretch + 1]!; row += 1) {
      const value = column[row]!;
      // NaN fails both comparisons.
      if (value < low) {
        low = value;
        lowAt = row;
      }
      if (value > high) {
        high = value;
        highAt = row;
      }
    }
    if (lowAt < 0) continue;
    const rising = lowAt <= highAt;
    out[2 * stretch] = rising ? low : high;
    out[2 * stretch + 1] = rising ? high : low;
  }
  return out;
}

/** Find where the line is interrupted: no value for longer than `threshold` seconds. */
export function findHoles(times: readonly number[], values: Readonly<Cells>, threshold: number): [number, number][] {
  const found: [number, number][] = [];
  let before = NaN;
  for (let row = 0; row < values.length; row += 1) {
    if (values[row] === null) continue;
    const time = times[row]!;
    if (time - before > threshold) found.push([before, time]);
    before = time;
  }
  return found;
}

/** Merge two decimations on one time line, the second `lag` seconds later. Cells without a row are undefined: the line passes straight. */
export function mergeTimelines(one: Decimated, other: Decimated, lag: number): { times: number[]; values: Cells[] } {
  const times: number[] = [];
  const rows: number[] = [];
  const others: number[] = [];
  let row = 0;
  let next = 0;
  while (row < one.times.length || next < other.times.length) {
    const firstTime = one.times[row] ?? Infinity;
    const secondTime = next < other.times.length ? other.times[next]! + lag : Infinity;
    times.push(Math.min(firstTime, secondTime));
    rows.push(firstTime <= secondTime ? row++ : -1);
    others.push(secondTime <= firstTime ? next++ : -1);
  }
  const placed = (from: number[]) => (cells: Cells) => from.map((at) => (at < 0 ? undefined : cells[at]));
  return { times, values: [...one.values.map(placed(rows)), ...other.values.map(placed(others))] };
}
