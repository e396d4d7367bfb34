// Plays a recording in place of the live data: play, pause, step, seek, loop. It is a `Source`, like the live data.
import { frameClock } from "../platform/frameClock.svelte";
import type { Latest } from "../live/live.svelte";
import { RecordingData } from "./recordingData.svelte";
import type { Comparison } from "./comparison.svelte";
import type { ApiClient } from "../api/api";
import type { Display, Source } from "../display/source.svelte";

/** Seconds: an older value is not shown at the player's position. */
const REACH = 30;
/** Seconds: a longer frame (hidden tab) does not move the position further than this. */
const LEAP = 0.25;

export const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16] as const;

export class Player extends RecordingData implements Source {
  readonly kind = "recording";
  /** The position: seconds of the recording's own clock, between `first` and `last`. */
  position = $state(0);
  playing = $state(false);
  speed = $state<number>(1);
  loop = $state.raw<{ from: number; to: number } | null>(null);

  /** The recording that Live, Chart and Faults show; null: live data. */
  readonly shown = $derived.by(() => (this.display.source === this ? this.detail : null));

  private frame = 0;
  private before = 0;

  constructor(
    api: ApiClient,
    private readonly comparison: Comparison,
    private readonly display: Display,
  ) {
    super(api);
  }

  get paused(): boolean {
    return !this.playing;
  }

  get absent(): readonly string[] {
    return this.detail?.absent ?? [];
  }

  get since(): number {
    const units = this.events.filter((event) => event.kind === "unit" && event.another && event.time <= this.position);
    return units.at(-1)?.time ?? -Infinity;
  }

  /** Show a recording in place of the live data. Throws `ApiError` if it can't be read. */
  async open(id: string): Promise<void> {
    this.close();
    if (!(await this.load(id))) return;
    this.position = this.first;
    this.display.play(this);
  }

  /** Return to the live data. */
  close(): void {
    this.comparison.end();
    this.pause();
    this.loop = null;
    this.reset();
    if (this.display.source === this) this.display.goLive();
  }

  play(): void {
    if (!this.detail || this.playing) return;
    if (this.position >= this.last) this.position = this.loop?.from ?? this.first;
    this.playing = true;
    this.before = performance.now();
    this.frame = requestAnimationFrame((now) => this.go(now));
  }

  pause(): void {
    this.playing = false;
    cancelAnimationFrame(this.frame);
    frameClock.request();
  }

  toggle(): void {
    if (this.playing) this.pause();
    else this.play();
  }

  seek(time: number): void {
    this.position = Math.min(this.last, Math.max(this.first, time));
    frameClock.request();
  }

  /** Move by samples and pause. */
  step(samples: number): void {
    this.pause();
    const { columns } = this;
    if (columns.length === 0) return;
    const row = columns.rowAt(this.position + 1e-6) + samples;
    this.seek(columns.times()[Math.min(columns.length - 1, Math.max(0, row))]!);
  }

  now(): number {
    return this.position;
  }

  latest(name: string): Latest | undefined {
    const found = this.columns.valueAt(name, this.columns.rowAt(this.position), REACH);
    const time = found && this.columns.times()[found.row]!;
    return time === undefined || time < this.since ? undefined : { value: found!.value, time };
  }

  private go(now: number): void {
    if (!this.playing) return;
    const passed = Math.min(LEAP, (now - this.before) / 1000) * this.speed;
    this.before = now;
    this.position = advance(this.position, passed, this.last, this.loop);
    frameClock.request();
    if (this.position >= this.last && !this.loop) this.pause();
    else this.frame = requestAnimationFrame((next) => this.go(next));
  }
}

/** The position after `seconds` of playing: it stays within the loop if it was in it, and ends at `last`. */
export function advance(position: number, seconds: number, last: number, loop: { from: number; to: number } | null): number {
  const next = position + seconds;
  if (loop && loop.to > loop.from && position <= loop.to && next > loop.to) {
    return loop.from + ((next - loop.to) % (loop.to - loop.from));
  }
  return Math.min(last, next);
}
