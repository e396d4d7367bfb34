// What Live and Chart display: live data or a recording, behind one interface.
import { frameClock } from "../platform/frameClock.svelte";
import type { Columns } from "../series/columns";
import { live, type Latest } from "../live/live.svelte";
import type { LineEvent } from "../api/types";

export interface Extremes {
  min: number;
  max: number;
}

export interface Source {
  readonly kind: "live" | "recording";
  /** Counts changes of the data: effects that draw depend on it. */
  readonly tick: number;
  readonly columns: Columns;
  readonly events: readonly LineEvent[];
  /** The time shown: now, the time at which the view was frozen, or the player's position. */
  now(): number;
  /** The last value at or before that time. */
  latest(name: string): Latest | undefined;
  /** Minimum and maximum: live since the last reset, of a recording over all of it. */
  extremes(name: string): Extremes | undefined;
  /** Live: the view is frozen (sampling and recording continue). Recording: the player is paused. */
  readonly paused: boolean;
  toggle(): void;
  /** Called when another source is displayed: release the data. */
  leave?(): void;
}

class LiveSource implements Source {
  readonly kind = "live";
  readonly columns = live.columns;
  private frozen = $state<number | null>(null);

  get tick(): number {
    return live.tick;
  }

  get events(): readonly LineEvent[] {
    return live.events;
  }

  get paused(): boolean {
    return this.frozen !== null;
  }

  now(): number {
    return this.frozen ?? live.now();
  }

  latest(name: string): Latest | undefined {
    if (this.frozen === null) return live.latest.get(name);
    const found = this.columns.valueAt(name, this.columns.rowAt(this.frozen), 30);
    return found && { value: found.value, time: this.columns.times()[found.row]! };
  }

  extremes(name: string): Extremes | undefined {
    return live.extremes.get(name);
  }

  toggle(): void {
    this.frozen = this.frozen === null ? live.now() : null;
    frameClock.request();
  }

  resume(): void {
    this.frozen = null;
  }
}

export const liveSource = new LiveSource();

class Display {
  source = $state.raw<Source>(liveSource);

  play(recording: Source): void {
    this.source = recording;
    frameClock.request();
  }

  goLive(): void {
    const left = this.source;
    liveSource.resume();
    this.source = liveSource;
    left.leave?.();
    frameClock.request();
  }
}

export const display = new Display();
