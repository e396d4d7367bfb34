// The value axis: fitted with room, moved by gestures, or one lane for each trace when stacked.
import type { Stretch } from "../view.svelte";

/** The visible extremes with room, never so narrow that noise in the last digit fills the pane. */
export function fitting(min: number | null, max: number | null, least: number): [number, number] {
  if (min === null || max === null || !Number.isFinite(min) || !Number.isFinite(max)) return [0, 1];
  const extent = Math.max((max - min) * 1.12, least);
  const middle = (min + max) / 2;
  return [middle - extent / 2, middle + extent / 2];
}

/** Apply the moves made by wheel and drag. */
export function stretched([low, high]: [number, number], stretch: Stretch | undefined): [number, number] {
  if (!stretch) return [low, high];
  const extent = (high - low) * stretch.scale;
  const middle = (low + high) / 2 + (high - low) * stretch.shift;
  return [middle - extent / 2, middle + extent / 2];
}

/** The range that places [low, high] in lane `index` of `count`, the first one at the top. */
export function lane([low, high]: [number, number], index: number, count: number): [number, number] {
  const extent = (high - low) * count;
  const bottom = low - (high - low) * (count - 1 - index);
  return [bottom, bottom + extent];
}
