// The value axis: what fits, with room; moved by hand; a lane of its own for each trace when stacked.
import type { Stretch } from "../view.svelte";

/** Low and high of what is visible, with room, and never so close that the last digit's restlessness fills the pane. */
export function fitting(min: number | null, max: number | null, least: number): [number, number] {
  if (min === null || max === null || !Number.isFinite(min) || !Number.isFinite(max)) return [0, 1];
  const extent = Math.max((max - min) * 1.12, least);
  const middle = (min + max) / 2;
  return [middle - extent / 2, middle + extent / 2];
}

/** As moved by the wheel and the hand. */
export function stretched([low, high]: [number, number], stretch: Stretch | undefined): [number, number] {
  if (!stretch) return [low, high];
  const extent = (high - low) * stretch.scale;
  const middle = (low + high) / 2 + (high - low) * stretch.shift;
  return [middle - extent / 2, middle + extent / 2];
}

/** The range that puts [low, high] into lane `index` of `count`, the first one at the top. */
export function lane([low, high]: [number, number], index: number, count: number): [number, number] {
  const extent = (high - low) * count;
  const bottom = low - (high - low) * (count - 1 - index);
  return [bottom, bottom + extent];
}
