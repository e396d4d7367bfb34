// A cloud of points as a raster: each pixel knows how many points it has and the mean of their colour values, so that the picture does not
// depend on the order of the points, and a further point costs the same after a million.
import type { Pairs } from "./pairs";

/** The visible ranges: of `x` from left to right, of `y` from the bottom up. */
export interface Frame {
  x: readonly [number, number];
  y: readonly [number, number];
}

export class Cloud {
  /** Pairs read so far. */
  taken = 0;
  /** Pairs outside the frame, and those inside without a colour value. */
  outside = 0;
  colourless = 0;
  readonly count: Uint32Array;
  /** Points of a pixel that have a colour value, and the sum of these values. */
  readonly coloured: Uint32Array;
  readonly sum: Float64Array;
  /** The pixels with points. */
  readonly touched: Uint32Array;
  used = 0;

  /**
   * `width`, `height`: pixels. `values[0]` of the pairs is y, `values[1]` x, `values[2]`, if there is one, the colour. `before`: a cloud of the
   * same size that is no longer used; its memory is.
   */
  constructor(
    readonly width: number,
    readonly height: number,
    readonly frame: Frame,
    before?: Cloud | null,
  ) {
    const size = width * height;
    const reused = before?.count.length === size ? before : null;
    this.count = reused?.count ?? new Uint32Array(size);
    this.coloured = reused?.coloured ?? new Uint32Array(size);
    this.sum = reused?.sum ?? new Float64Array(size);
    this.touched = reused?.touched ?? new Uint32Array(size);
    if (!reused) return;
    for (let at = 0; at < reused.used; at += 1) {
      const pixel = this.touched[at]!;
      this.count[pixel] = this.coloured[pixel] = this.sum[pixel] = 0;
    }
  }

  /** Add at most `most` further pairs. Returns whether pairs are left. */
  take(pairs: Pairs, most: number): boolean {
    const { width, height, count, coloured, sum, touched } = this;
    const [y, x, colour] = [pairs.values[0]!, pairs.values[1]!, pairs.values[2]];
    const { left, top, across, down } = this.scale();
    const to = Math.min(pairs.length, this.taken + most);
    for (let at = this.taken; at < to; at += 1) {
      const column = Math.round((x[at]! - left) * across);
      const row = Math.round((top - y[at]!) * down);
      if (column < 0 || column >= width || row < 0 || row >= height) {
        this.outside += 1;
        continue;
      }
      const pixel = row * width + column;
      if (count[pixel]! === 0) touched[this.used++] = pixel;
      count[pixel]! += 1;
      const value = colour ? colour[at]! : NaN;
      if (value !== value) {
        this.colourless += 1;
        continue;
      }
      coloured[pixel]! += 1;
      sum[pixel]! += value;
    }
    this.taken = to;
    return to < pairs.length;
  }

  /** The place of a point in pixels. */
  place(x: number, y: number): [number, number] {
    const { left, top, across, down } = this.scale();
    return [(x - left) * across, (top - y) * down];
  }

  private scale(): { left: number; top: number; across: number; down: number } {
    const { x, y } = this.frame;
    return { left: x[0], top: y[1], across: (this.width - 1) / (x[1] - x[0]), down: (this.height - 1) / (y[1] - y[0]) };
  }

  /** The pair nearest to a place in pixels, within `reach` of it; -1: none. */
  nearest(pairs: Pairs, column: number, row: number, reach: number): number {
    const [y, x] = [pairs.values[0]!, pairs.values[1]!];
    let found = -1;
    let best = reach * reach;
    const { left, top, across, down } = this.scale();
    for (let at = 0; at < this.taken; at += 1) {
      const away = (x[at]! - left) * across - column;
      const above = (top - y[at]!) * down - row;
      const distance = away * away + above * above;
      if (distance > best) continue;
      best = distance;
      found = at;
    }
    return found;
  }

  /** The numbers of the pairs inside a polygon of places in pixels (even-odd rule), ascending. */
  inside(pairs: Pairs, polygon: readonly (readonly [number, number])[]): number[] {
    const [y, x] = [pairs.values[0]!, pairs.values[1]!];
    const { left, top, across, down } = this.scale();
    const low = Math.min(...polygon.map(([, row]) => row));
    const high = Math.max(...polygon.map(([, row]) => row));
    const found: number[] = [];
    for (let at = 0; at < this.taken; at += 1) {
      const row = (top - y[at]!) * down;
      if (row < low || row > high) continue;
      if (isInside(polygon, (x[at]! - left) * across, row)) found.push(at);
    }
    return found;
  }
}

function isInside(polygon: readonly (readonly [number, number])[], column: number, row: number): boolean {
  let inside = false;
  for (let at = 0, before = polygon.length - 1; at < polygon.length; before = at, at += 1) {
    const [x, y] = polygon[at]!;
    const [fromX, fromY] = polygon[before]!;
    if (y > row !== fromY > row && column < ((fromX - x) * (row - y)) / (fromY - y) + x) inside = !inside;
  }
  return inside;
}

/** Colours of a picture as 0xAABBGGRR. */
export interface Inks {
  /** From the lowest to the highest colour value. */
  ramp: Uint32Array;
  /** The values of the ramp's ends; with `density`: logarithms of counts. Equal ends: everything has the middle of the ramp. */
  low: number;
  high: number;
  /** Of points without a colour value. */
  plain: number;
  /** Colours by the number of points at a place, in place of a channel. */
  density: boolean;
  /** Pixels of a point's side. */
  side: number;
}

/** Paint the points over what is in `pixels` (`width` × `height` of the cloud), as squares. */
export function paint(cloud: Cloud, pixels: Uint32Array, inks: Inks): void {
  const { width, height, count, coloured, sum, touched } = cloud;
  const before = inks.side >> 1;
  const after = inks.side - before;
  for (let at = 0; at < cloud.used; at += 1) {
    const pixel = touched[at]!;
    const ink = inkOf(inks, count[pixel]!, coloured[pixel]!, sum[pixel]!);
    const row = (pixel / width) | 0;
    const column = pixel - row * width;
    const right = Math.min(width, column + after);
    const bottom = Math.min(height, row + after);
    for (let y = Math.max(0, row - before); y < bottom; y += 1) {
      for (let x = Math.max(0, column - before); x < right; x += 1) pixels[y * width + x] = ink;
    }
  }
}

function inkOf({ ramp, low, high, plain, density }: Inks, count: number, coloured: number, sum: number): number {
  if (density) return ramp[Math.round(shareOf(Math.log(count), low, high) * (ramp.length - 1))]!;
  if (coloured === 0) return plain;
  return ramp[Math.round(shareOf(sum / coloured, low, high) * (ramp.length - 1))]!;
}

/** Where a value is between two others, 0 … 1. */
export function shareOf(value: number, low: number, high: number): number {
  if (!(high > low)) return 0.5;
  return Math.min(1, Math.max(0, (value - low) / (high - low)));
}

/** The most points in one pixel. */
export function densest(cloud: Cloud): number {
  let most = 1;
  for (let at = 0; at < cloud.used; at += 1) most = Math.max(most, cloud.count[cloud.touched[at]!]!);
  return most;
}
