// What of the columns a chart of so many pixels has to draw. Up to two rows a pixel: all. More: the lowest and the highest of every
// stretch, in the order in which they came, so that no spike is lost. Stretches lie on a fixed grid of time: when the window moves on, what
// was drawn stays as it was and does not shimmer.
import type { Columns } from "./columns";

export type Cells = (number | null | undefined)[];

export interface Decimated {
  times: number[];
  /** A column a name; null where there is nothing, undefined where the line between its neighbours passes anyway. */
  values: Cells[];
  /** Seconds a stretch; 0: all rows are here. */
  width: number;
}

export function decimate(
  columns: Columns,
  names: readonly string[],
  from: number,
  to: number,
  pixels: number,
): Decimated {
  // One row more at either side: the line goes on to the edge.
  const first = Math.max(0, columns.rowAt(from));
  const last = Math.min(columns.length, columns.rowAt(to) + 2);
  const times = columns.times(first, last);
  if (times.length <= 2 * pixels || !(to > from)) {
    return { times: [...times], values: names.map((name) => dropFlatPoints(allRows(columns.column(name, first, last), times.length))), width: 0 };
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

/** So many at either end stay: some lie beyond the window, and what is in it must have a value to be scaled by. */
const EDGE_ROWS = 4;

/** Of a level stretch only the ends are drawn: most channels stand still for many rows, and each point costs. */
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

/** Which stretches have rows: their numbers on the grid, and where in the rows each begins (and the last one ends). */
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
      // NaN is neither.
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

/** Where the line is not to be drawn: longer than `apart` seconds without a value. */
export function findHoles(
  times: readonly number[],
  values: Readonly<Cells>,
  threshold: number,
): [number, number][] {
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

/** Two on one line of time, the other's `lag` seconds later; where one has no row, its cells are undefined: its line passes. */
export function mergeTimelines(one: Decimated, other: Decimated, lag: number): { times: number[]; values: Cells[] } {
  const times: number[] = [];
  const rows: number[] = [];
  const others: number[] = [];
  let row = 0;
  let next = 0;
  while (row < one.times.length || next < other.times.length) {
    const mine = one.times[row] ?? Infinity;
    const its = next < other.times.length ? other.times[next]! + lag : Infinity;
    times.push(Math.min(mine, its));
    rows.push(mine <= its ? row++ : -1);
    others.push(its <= mine ? next++ : -1);
  }
  const placed = (from: number[]) => (cells: Cells) => from.map((at) => (at < 0 ? undefined : cells[at]));
  return { times, values: [...one.values.map(placed(rows)), ...other.values.map(placed(others))] };
}
