// The data that the chart draws: the displayed source and, beside a recording, a second one to compare with.
import type { Display } from "../../../../lib/display/source.svelte";
import type { Comparison } from "../../../../lib/recording/comparison.svelte";
import type { Player } from "../../../../lib/recording/player.svelte";
import type { Later } from "../plot/drawing";
import { gapsOf, shiftedBy, type GapBand } from "./flags";
import { valueAt } from "./value";

export class ChartData {
  constructor(
    private readonly display: Display,
    private readonly player: Player,
    private readonly comparison: Comparison,
  ) {}

  /** The second recording at the times of the first; null: no comparison. */
  get second(): Later | null {
    const { active, columns, lag } = this.comparison;
    return active ? { columns, lag } : null;
  }

  /** Gaps of both sources in the window; without one: all. */
  gapsIn(from = -Infinity, to = Infinity): GapBand[] {
    const { source } = this.display;
    const own = gapsOf(source.events, from, to, source.kind === "recording" ? this.player.last : source.now());
    const { active, events, lag, last } = this.comparison;
    return active ? [...own, ...shiftedBy(gapsOf(events, from - lag, to - lag, last), lag)] : own;
  }

  valueOf(name: string, time: number): number | null {
    return valueAt(this.display.source.columns, this.display.source.events, name, time);
  }

  secondValueOf(name: string, time: number): number | null {
    return valueAt(this.comparison.columns, this.comparison.events, name, time - this.comparison.lag);
  }

  /** The time of interest: the cursor, or the player's position; null for live data without a cursor. */
  moment(cursor: number | null): number | null {
    return cursor ?? (this.display.source.kind === "recording" ? this.display.source.now() : null);
  }
}
