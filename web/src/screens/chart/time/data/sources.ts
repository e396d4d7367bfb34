// The data that the chart draws: the displayed source and, beside a recording, a second one to compare with.
import { comparison } from "../../../../lib/recording/comparison.svelte";
import { player } from "../../../../lib/recording/player.svelte";
import { display } from "../../../../lib/display/source.svelte";
import type { Later } from "../plot/drawing";
import { gapsOf, shiftedBy, type GapBand } from "./flags";
import { valueAt } from "./value";

/** The second recording at the times of the first; null: no comparison. */
export const second = (): Later | null => (comparison.active ? { columns: comparison.columns, lag: comparison.lag } : null);

/** Gaps of both sources in the window. */
export function gapsIn(from: number, to: number): GapBand[] {
  const { source } = display;
  const own = gapsOf(source.events, from, to, source.kind === "recording" ? player.last : source.now());
  if (!comparison.active) return own;
  const { lag } = comparison;
  return [...own, ...shiftedBy(gapsOf(comparison.events, from - lag, to - lag, comparison.last), lag)];
}

/** All gaps. */
export const everyGap = (): GapBand[] => gapsIn(-Infinity, Infinity);

export const valueOf = (name: string, time: number): number | null => valueAt(display.source.columns, display.source.events, name, time);

export const secondValueOf = (name: string, time: number): number | null =>
  valueAt(comparison.columns, comparison.events, name, time - comparison.lag);

/** The time of interest: the cursor, or the player's position; null for live data without a cursor. */
export function moment(cursor: number | null): number | null {
  return cursor ?? (display.source.kind === "recording" ? display.source.now() : null);
}
