// What Live and Chart display: live data or a recording, behind one interface.
import { displayValueOf, isInGap, NONE, type DisplayValue } from "../channels/displayValue";
import { frameClock } from "../platform/frameClock.svelte";
import type { Columns, Extremes } from "../series/columns";
import type { Pulses } from "../series/pulses";
import type { Latest, Live } from "../live/live.svelte";
import type { LineEvent } from "../api/types";

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
  /** Channels that the unit shown does not have: it controls the ignition alone. */
  readonly absent: readonly string[];
  /** Since when the unit shown answers: earlier values are another car's. */
  readonly since: number;
  /** Minimum and maximum: live since the last reset, of a recording over all of it. */
  extremes(name: string): Extremes | undefined;
  /** How often a flag was set, over the same time. */
  pulses(name: string): Pulses;
  /** Live: the view is frozen (sampling and recording continue). Recording: the player is paused. */
  readonly paused: boolean;
  toggle(): void;
  /** Called when another source is displayed: release the data. */
  close?(): void;
}

class LiveSource implements Source {
  readonly kind = "live";
  readonly columns: Columns;
  /** Without what the date was set by, which may change meanwhile. */
  private frozen = $state<number | null>(null);

  constructor(private readonly live: Live) {
    this.columns = live.columns;
  }

  get tick(): number {
    return this.live.tick;
  }

  get events(): readonly LineEvent[] {
    return this.live.events;
  }

  get absent(): readonly string[] {
    return this.live.state?.absent ?? [];
  }

  get since(): number {
    return this.live.unitSince;
  }

  get paused(): boolean {
    return this.frozen !== null;
  }

  now(): number {
    return this.frozen === null ? this.live.now() : this.frozen + this.live.later;
  }

  latest(name: string): Latest | undefined {
    if (this.frozen === null) return this.live.latest.get(name);
    const found = this.columns.valueAt(name, this.columns.rowAt(this.now()), 30);
    return found && { value: found.value, time: this.columns.times()[found.row]! };
  }

  extremes(name: string): Extremes | undefined {
    return this.live.extremes.get(name);
  }

  pulses(name: string): Pulses {
    return this.live.pulses(name);
  }

  toggle(): void {
    this.frozen = this.frozen === null ? this.live.now() - this.live.later : null;
    frameClock.request();
  }

  resume(): void {
    this.frozen = null;
  }
}

export class Display {
  readonly live: LiveSource;
  source: Source = $state.raw<Source>()!;
  /** Called when another source is shown. */
  onshown: () => void = () => undefined;

  constructor(private readonly line: Live) {
    this.source = this.live = new LiveSource(line);
  }

  play(recording: Source): void {
    this.source = recording;
    this.onshown();
    frameClock.request();
  }

  goLive(): void {
    const left = this.source;
    this.live.resume();
    this.source = this.live;
    left.close?.();
    this.onshown();
    frameClock.request();
  }

  /** The value of a channel that is shown now. Depends on time: read `frameClock.fast` as well. */
  value(name: string): DisplayValue {
    const { source, line } = this;
    const latest = source.latest(name);
    if (isInGap(source.events, latest, source.now())) return NONE;
    if (source.kind === "recording") return displayValueOf(latest, source.now(), 0);
    if (line.link !== "open" || line.state?.line !== "sampling") return NONE;
    return displayValueOf(latest, source.now(), this.period(name));
  }

  /** Seconds between two values of this channel in the current plan. */
  private period(name: string): number {
    const { state } = this.line;
    if (!state || state.rate <= 0) return 0;
    const cycles = state.plan.wanted.find((wanted) => wanted.name === name)?.cycles ?? 1;
    return cycles / state.rate;
  }
}
