// Draws lines on a canvas: sparklines and strips. At most two points a pixel, minimum and maximum, so that spikes stay visible.
import { gapThreshold } from "./gapThreshold";
import type { Columns } from "./columns";

export interface Frame {
  from: number;
  to: number;
  low: number;
  high: number;
}

/** Clear the canvas and return its context in CSS pixels; null while it has no size. */
export function prepareCanvas(canvas: HTMLCanvasElement): { context: CanvasRenderingContext2D; width: number; height: number } | null {
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (width === 0 || height === 0) return null;
  const scale = window.devicePixelRatio || 1;
  const across = Math.round(width * scale);
  const down = Math.round(height * scale);
  if (canvas.width !== across || canvas.height !== down) {
    canvas.width = across;
    canvas.height = down;
  }
  const context = canvas.getContext("2d");
  if (!context) return null;
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

/** Minimum and maximum between two times; undefined without values. */
export function extremesBetween(columns: Columns, name: string, from: number, to: number): { min: number; max: number } | undefined {
  const first = columns.rowAt(from) + 1;
  const last = columns.rowAt(to) + 1;
  const column = columns.column(name, first, last);
  if (!column) return undefined;
  let min = Infinity;
  let max = -Infinity;
  for (const value of column) {
    if (value < min) min = value;
    if (value > max) max = value;
  }
  return min <= max ? { min, max } : undefined;
}

/** Add the line of `name` to the context's path; the caller strokes it. */
export function drawTrace(
  context: CanvasRenderingContext2D,
  columns: Columns,
  name: string,
  frame: Frame,
  width: number,
  height: number,
  pad = 2,
): void {
  const first = columns.rowAt(frame.from) + 1;
  const last = columns.rowAt(frame.to) + 1;
  const times = columns.times(first, last);
  const values = columns.column(name, first, last);
  if (!values) return;
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
  for (let row = 0; row < values.length; row += 1) {
    const value = values[row]!;
    if (Number.isNaN(value)) continue;
    const time = times[row]!;
    const x = Math.round((time - frame.from) * perSecond * 2) / 2;
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
