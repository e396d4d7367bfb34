// A recording in the place of the live line: play, pause, step, scrub, loop. It is read whole, in pieces, from its beginning; until the last has
// come a coarse view of all of it stands in, so that the chart has something at once. A `Source` like the live line.
import { ApiError, api } from "./api";
import { beat } from "./beat.svelte";
import { Columns } from "./columns";
import type { Latest } from "./live.svelte";
import { shown, type Extremes, type Source } from "./source.svelte";
import type { LineEvent, RecordingDetail } from "./types";

/** Rows of a piece, and of the coarse view. */
const PIECE = 15_000;
const COARSE = 4000;
/** More is not held here; such a recording stays coarse: eight hours at 35 sets a second. */
const MOST = 1_000_000;
/** A value older than this at the player's place is not shown. */
const REACH = 30;
/** A frame that took longer (a hidden tab) does not make the place leap. */
const LEAP = 0.25;

export const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16] as const;

class Player implements Source {
  readonly kind = "recording";
  detail = $state.raw<RecordingDetail | null>(null);
  /** Where it stands: seconds of the recording's own clock, between `first` and `last`. */
  position = $state(0);
  playing = $state(false);
  speed = $state<number>(1);
  loop = $state.raw<{ from: number; to: number } | null>(null);
  /** How much has been read, 0 … 1. */
  loaded = $state(0);
  /** Reading broke off; what was read stays. */
  trouble = $state.raw<ApiError | null>(null);
  tick = $state(0);
  columns = $state.raw(new Columns());

  private began = $state(0);
  /** The first sample, not the first byte: before it there is nothing to show. */
  readonly first = $derived(this.detail ? this.began : 0);
  readonly last = $derived(this.detail?.last ?? 0);
  /** Too long to be held whole: a step is not a sample, peaks stay. */
  readonly coarse = $derived((this.detail?.samples ?? 0) > MOST);

  private reading: AbortController | null = null;
  private frame = 0;
  private before = 0;
  private found = new Map<string, Extremes | undefined>();
  private foundAt = -1;

  get events(): readonly LineEvent[] {
    return this.detail?.events ?? [];
  }

  get paused(): boolean {
    return !this.playing;
  }

  /** Shows it in the place of the live line. Throws `ApiError` if it can't be read at all. */
  async open(id: string): Promise<void> {
    this.close();
    const reading = new AbortController();
    this.reading = reading;
    const detail = await api.recording(id);
    const rough = await api.rows(id, { from: detail.first, to: detail.last, points: COARSE }, reading.signal);
    if (reading.signal.aborted) return;
    this.columns = columnsOf(COARSE * 2);
    this.columns.append(rough.names, rough.times, rough.values);
    this.began = Math.max(detail.first, rough.times[0] ?? detail.first);
    this.detail = detail;
    this.position = this.began;
    this.tick += 1;
    shown.play(this);
    if (rough.decimated && !this.coarse) void this.read(id, detail, reading.signal);
    else this.loaded = 1;
  }

  /** Back to the live line. */
  close(): void {
    this.reading?.abort();
    this.reading = null;
    this.pause();
    this.detail = null;
    this.loop = null;
    this.loaded = 0;
    this.trouble = null;
    this.columns = new Columns();
    this.tick += 1;
    if (shown.source === this) shown.goLive();
  }

  leave(): void {
    this.close();
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
    beat.poke();
  }

  toggle(): void {
    if (this.playing) this.pause();
    else this.play();
  }

  seek(time: number): void {
    this.position = Math.min(this.last, Math.max(this.first, time));
    beat.poke();
  }

  /** To the next sample, or the one before. Stops. */
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
    const held = this.columns.valueAt(name, this.columns.rowAt(this.position), REACH);
    return held && { value: held.value, time: this.columns.times()[held.row]! };
  }

  extremes(name: string): Extremes | undefined {
    if (this.foundAt !== this.tick) {
      this.found.clear();
      this.foundAt = this.tick;
    }
    if (!this.found.has(name)) this.found.set(name, extremesOf(this.columns.column(name)));
    return this.found.get(name);
  }

  private go(now: number): void {
    if (!this.playing) return;
    const passed = Math.min(LEAP, (now - this.before) / 1000) * this.speed;
    this.before = now;
    this.position = advance(this.position, passed, this.last, this.loop);
    beat.poke();
    if (this.position >= this.last && !this.loop) this.pause();
    else this.frame = requestAnimationFrame((next) => this.go(next));
  }

  private async read(id: string, detail: RecordingDetail, signal: AbortSignal): Promise<void> {
    const whole = columnsOf(detail.samples);
    const length = Math.max(1e-6, detail.last - detail.first);
    const rate = Math.max(detail.rate, detail.samples / length);
    // Pieces by time; where samples lie closer than on average a piece would be decimated, and is asked again in halves.
    let seconds = Math.max(1, PIECE / Math.max(1, rate));
    let from = detail.first;
    try {
      while (from <= detail.last) {
        const to = Math.min(from + seconds, detail.last + 1);
        const rows = await api.rows(id, { from, to, points: PIECE * 1.3 }, signal);
        if (signal.aborted) return;
        if (rows.decimated && seconds > 0.5) {
          seconds /= 2;
          continue;
        }
        whole.append(rows.names, rows.times, rows.values);
        from = to + 1e-6;
        this.loaded = Math.min(1, (from - detail.first) / length);
      }
      this.columns = whole;
      this.loaded = 1;
      this.tick += 1;
      beat.poke();
    } catch (error) {
      if (signal.aborted) return;
      if (!(error instanceof ApiError)) throw error;
      this.trouble = error;
    }
  }
}

const columnsOf = (rows: number): Columns => new Columns(Math.max(16, Math.ceil(rows * 1.1) + 16));

function extremesOf(column: Float64Array | undefined): Extremes | undefined {
  if (!column) return undefined;
  let min = Infinity;
  let max = -Infinity;
  for (const value of column) {
    if (value < min) min = value;
    if (value > max) max = value;
  }
  return min <= max ? { min, max } : undefined;
}

/** The place after so many seconds more: within the loop if it was in it, else to the end and no farther. */
export function advance(
  position: number,
  seconds: number,
  last: number,
  loop: { from: number; to: number } | null,
): number {
  const next = position + seconds;
  if (loop && loop.to > loop.from && position <= loop.to && next > loop.to) {
    return loop.from + ((next - loop.to) % (loop.to - loop.from));
  }
  return Math.min(last, next);
}

export const player = new Player();
