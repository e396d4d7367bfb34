// The path of a line on a canvas: sparklines and strips. Minimum and maximum of each pixel, so that spikes stay visible.
import { gapThreshold } from "./gapThreshold";
import { extremesOf, type Columns, type Extremes } from "./columns";

export interface Frame {
  from: number;
  to: number;
  low: number;
  high: number;
  /** Earlier values are another unit's. */
  since?: number;
}

/** Minimum and maximum between two times; undefined without values. */
export function extremesBetween(columns: Columns, name: string, from: number, to: number): Extremes | undefined {
  return extremesOf(columns.column(name, columns.rowAt(from) + 1, columns.rowAt(to) + 1) ?? []);
}

/** Add the line of `name` to the context's path, in pixels; the caller strokes it. `after`: the line is drawn already up to this time. */
export function drawTrace(
  context: Pick<CanvasRenderingContext2D, "moveTo" | "lineTo">,
  columns: Columns,
  name: string,
  frame: Frame,
  width: number,
  height: number,
  pad = 2,
  after = -Infinity,
): void {
  const first = Math.max(columns.rowAt(frame.from) + 1, columns.rowFrom(frame.since ?? -Infinity));
  const last = columns.rowAt(frame.to) + 1;
  const values = columns.column(name, first, last);
  if (!values) return;
  const times = columns.times(first, last);
  const longest = gapThreshold(columns, name, first, last);
  const perSecond = width / (frame.to - frame.from);
  const perUnit = (height - 2 * pad) / (frame.high - frame.low || 1);
  const y = (value: number) => height - pad - (value - frame.low) * perUnit;
  let pixel = -1;
  let low = 0;
  let high = 0;
  let end = 0;
  let before = -Infinity;
  const flush = () => {
    if (pixel < 0 || low === high) return;
    context.lineTo(pixel, y(low));
    context.lineTo(pixel, y(high));
    context.lineTo(pixel, y(end));
  };
  // Begin at the last value that is drawn already.
  let row = after === -Infinity ? 0 : Math.max(0, columns.rowAt(after) - first);
  while (row > 0 && Number.isNaN(values[row]!)) row -= 1;
  for (; row < values.length; row += 1) {
    const value = values[row]!;
    if (Number.isNaN(value)) continue;
    const time = times[row]!;
    const x = Math.round((time - frame.from) * perSecond);
    if (x === pixel && time - before <= longest) {
      if (value < low) low = value;
      if (value > high) high = value;
    } else {
      flush();
      if (time - before > longest) context.moveTo(x, y(value));
      else context.lineTo(x, y(value));
      pixel = x;
      low = high = value;
    }
    end = value;
    before = time;
  }
  flush();
}
