// What one pane draws: its traces, those of the second recording on the same time line, and where each line is interrupted.
import { decimate, findHoles, mergeTimelines, type Cells, type Decimated } from "../../../../lib/series/decimate";
import type { Columns, Extremes } from "../../../../lib/series/columns";
import { gapThreshold } from "../../../../lib/series/gapThreshold";
import type { Axis, Line } from "../../../../lib/series/valueAxis";
import type { Stores } from "../../../../stores";
import type { Trace } from "../view.svelte";
import { paneAxes } from "./scales";

export interface Drawing {
  times: number[];
  values: Cells[];
  /** A list of [from, to] for each line. */
  holes: [number, number][][];
}

export interface Later {
  columns: Columns;
  lag: number;
}

export interface DrawnPane extends Drawing {
  /** The traces of the lines: those of the second recording follow in the same order. */
  shown: readonly Trace[];
  lines: Line[];
  axes: Axis[];
}

/** The lines of a pane's traces that are not hidden, with the axis of each. `width`, `height`: of its plot in pixels. */
export function drawnPane(stores: Stores, traces: readonly Trace[], from: number, to: number, width: number, height: number): DrawnPane {
  const { catalog, chartData, display, reference, view } = stores;
  const shown = traces.filter(({ hidden }) => !hidden);
  const names = shown.map(({ name }) => name);
  const drawn = drawing(display.source.columns, chartData.second, names, from, to, width);
  const lines = drawn.values.map((cells, index) => {
    const name = names[index % names.length]!;
    return { name, channel: catalog.get(name), seen: seenIn(drawn.times, cells, from, to), cells, band: reference.bands.get(name) };
  });
  return { ...drawn, shown, lines, axes: paneAxes(lines, names.length, view.stacked, height) };
}

export function drawing(
  columns: Columns,
  second: Later | null,
  names: readonly string[],
  from: number,
  to: number,
  pixels: number,
): Drawing {
  const own = decimate(columns, names, from, to, pixels);
  const broken = brokenIn(own, columns, names, from, to);
  if (!second) return { times: own.times, values: own.values, holes: broken };
  const { lag } = second;
  // Dashed lines are the most expensive: half the resolution is enough for them.
  const other = decimate(second.columns, names, from - lag, to - lag, pixels / 2);
  const later = brokenIn(other, second.columns, names, from - lag, to - lag).map((spans) =>
    spans.map(([begin, end]): [number, number] => [begin + lag, end + lag]),
  );
  return { ...mergeTimelines(own, other, lag), holes: [...broken, ...later] };
}

/** The extremes of the points in the window; if it has none, of those beside it, between which the line passes. */
export function seenIn(times: readonly number[], cells: Cells, from: number, to: number): Extremes | null {
  let min = Infinity;
  let max = -Infinity;
  for (let row = 0; row < cells.length; row += 1) {
    const value = cells[row];
    if (value === null || value === undefined || times[row]! < from || times[row]! > to) continue;
    if (value < min) min = value;
    if (value > max) max = value;
  }
  if (min <= max) return { min, max };
  return from === -Infinity ? null : seenIn(times, cells, -Infinity, Infinity);
}

/** Where each line is interrupted. Afterwards null is replaced by undefined: both draw nothing, and a single kind is faster. */
function brokenIn(gathered: Decimated, columns: Columns, names: readonly string[], from: number, to: number): [number, number][][] {
  const first = Math.max(0, columns.rowAt(from));
  const last = columns.rowAt(to) + 1;
  return gathered.values.map((cells, line) => {
    // The distance between two buckets is not a gap.
    const longest = Math.max(gapThreshold(columns, names[line]!, first, last), 1.1 * gathered.width);
    const found = findHoles(gathered.times, cells, longest);
    for (let row = 0; row < cells.length; row += 1) cells[row] ??= undefined;
    return found;
  });
}
