// What the chart draws from: the source that is shown and, beside a recording, a second one.
import { compared } from "../../../lib/recording/comparison.svelte";
import { player } from "../../../lib/recording/player.svelte";
import { shown } from "../../../lib/view/source.svelte";
import type { Later } from "../plot/drawing";
import { gapsOf, lagging, type GapBand } from "./flags";
import { valueAt } from "./value";

/** The second recording, at the times of the first; null: there is none. */
export const second = (): Later | null => (compared.on ? { columns: compared.columns, lag: compared.lag } : null);

/** Gaps of both in the window. */
export function gapsIn(from: number, to: number): GapBand[] {
  const { source } = shown;
  const own = gapsOf(source.events, from, to, source.kind === "recording" ? player.last : source.now());
  if (!compared.on) return own;
  const { lag } = compared;
  return [...own, ...lagging(gapsOf(compared.events, from - lag, to - lag, compared.last), lag)];
}

/** All there are. */
export const everyGap = (): GapBand[] => gapsIn(-Infinity, Infinity);

export const valueOf = (name: string, time: number): number | null =>
  valueAt(shown.source.columns, shown.source.events, name, time);

export const secondValueOf = (name: string, time: number): number | null =>
  valueAt(compared.columns, compared.events, name, time - compared.lag);

/** The moment that is looked at: the cursor, or where the player stands; live without a cursor: none. */
export function moment(cursor: number | null): number | null {
  return cursor ?? (shown.source.kind === "recording" ? shown.source.now() : null);
}
