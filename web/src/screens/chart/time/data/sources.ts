// The data that the chart draws: the displayed source and, beside a recording, a second one to compare with.
import type { Later } from "../plot/drawing";
import { gapsOf, shiftedBy, type GapBand } from "./flags";
import { valueAt } from "./value";
import type { Stores } from "../../../../stores";

export class ChartData {
  constructor(private readonly app: Pick<Stores, "comparison" | "cursors" | "display" | "player">) {}

  /** The second recording at the times of the first; null: no comparison. */
  get second(): Later | null {
    const { active, columns, lag } = this.app.comparison;
    return active ? { columns, lag } : null;
  }

  /** Gaps of both sources in the window; without one: all. */
  gapsIn(from = -Infinity, to = Infinity): GapBand[] {
    const { source } = this.app.display;
    const own = gapsOf(source.events, from, to, source.kind === "recording" ? this.app.player.last : source.now());
    const { active, events, lag, last } = this.app.comparison;
    return active ? [...own, ...shiftedBy(gapsOf(events, from - lag, to - lag, last), lag)] : own;
  }

  valueOf(name: string, time: number): number | null {
    return valueAt(this.app.display.source.columns, this.app.display.source.events, name, time);
  }

  secondValueOf(name: string, time: number): number | null {
    return valueAt(this.app.comparison.columns, this.app.comparison.events, name, time - this.app.comparison.lag);
  }

  /** The time of interest: the cursor, or the player's position; null for live data without a cursor. */
  get moment(): number | null {
    return this.app.cursors.a ?? (this.app.display.source.kind === "recording" ? this.app.display.source.now() : null);
  }
}
