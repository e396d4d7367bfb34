// Lines of the last seconds on a canvas that moves to the left: sparklines and strips. What is drawn already is shifted by whole pixels and
// only the new piece is added, because stroking all points of a dozen canvases several times a second costs more than the rest of the page.
// All of it is drawn again when a scale, the size, a colour or the data changes.
import type { Columns, Extremes } from "./columns";
import { drawTrace } from "./sparkline";

export interface Line {
  name: string;
  colour: string;
  low: number;
  high: number;
}

export interface Look {
  columns: Columns;
  /** The time at the right edge. */
  to: number;
  seconds: number;
  lines: readonly Line[];
  thickness: number;
  /** The time since when the values are of the unit that is shown. */
  since: number;
  /** Changes when rows were inserted before the last one: loaded history. */
  version: number;
}

export class RollingTraces {
  private width = 0;
  height = 0;
  private readonly observer: ResizeObserver;
  /** What the canvas shows: all that must be equal for a shift. */
  private key = "";
  private columns: Columns | null = null;
  /** The right edge in pixels since time 0. */
  private edge = 0;
  /** The time of the last row drawn. */
  private drawn = 0;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    onresize: () => void,
  ) {
    // Reading the size while drawing would force a layout each time.
    this.observer = new ResizeObserver((entries) => {
      const box = entries[entries.length - 1]!.contentRect;
      this.width = box.width;
      this.height = box.height;
      onresize();
    });
    this.observer.observe(canvas);
  }

  close(): void {
    this.observer.disconnect();
  }

  draw(look: Look): void {
    const scale = window.devicePixelRatio || 1;
    const across = Math.round(this.width * scale);
    const down = Math.round(this.height * scale);
    if (across === 0 || down === 0) return;
    const perPixel = look.seconds / across;
    const edge = Math.floor(look.to / perPixel);
    const key = JSON.stringify([across, down, look.seconds, look.thickness, look.version, look.since, look.lines]);
    const columns = look.columns;
    const same = key === this.key && columns === this.columns && columns.last >= this.drawn;
    const shift = edge - this.edge;
    if (same && shift === 0) return;
    const context = this.canvas.getContext("2d");
    if (!context) return;
    if (this.canvas.width !== across || this.canvas.height !== down) {
      this.canvas.width = across;
      this.canvas.height = down;
    }
    const rolling = same && shift > 0 && shift < across / 2;
    context.setTransform(1, 0, 0, 1, 0, 0);
    if (rolling) {
      context.globalCompositeOperation = "copy";
      context.drawImage(this.canvas, -shift, 0);
      context.globalCompositeOperation = "source-over";
    } else context.clearRect(0, 0, across, down);
    const right = edge * perPixel;
    const frame = { from: right - look.seconds, to: right, since: look.since };
    context.lineWidth = look.thickness * scale;
    context.lineJoin = "bevel";
    for (const line of look.lines) {
      context.strokeStyle = line.colour;
      context.beginPath();
      const after = rolling ? this.drawn : -Infinity;
      drawTrace(context, columns, line.name, { ...frame, ...line }, across, down, look.thickness * scale, after);
      context.stroke();
    }
    this.key = key;
    this.columns = columns;
    this.edge = edge;
    this.drawn = columns.times(0, columns.rowAt(right) + 1).at(-1) ?? -Infinity;
  }
}

/**
 * The scale of a small line: it grows at once, with room, and shrinks when the values need less than a third of it, so that it seldom changes.
 * `least`: the smallest span, so that noise in the last digit does not fill the picture.
 */
export function steadyScale(
  before: { low: number; high: number } | undefined,
  seen: Extremes,
  least: number,
): { low: number; high: number } {
  const needed = Math.max(seen.max - seen.min, least);
  if (before && seen.min >= before.low && seen.max <= before.high && before.high - before.low <= 3 * needed) return before;
  const span = Math.max((seen.max - seen.min) * 1.3, least);
  const middle = (seen.max + seen.min) / 2;
  return { low: middle - span / 2, high: middle + span / 2 };
}
