// A recording as columns. It is loaded completely, in parts, from its start; until then a decimated overview of all of it is shown.
import type { ApiClient } from "../api/api";
import { ApiError } from "../api/http";
import { frameClock } from "../platform/frameClock.svelte";
import { Columns, extremesOf, type Extremes } from "../series/columns";
import { PulseCounter, type Pulses } from "../series/pulses";
import type { Car, LineEvent, RecordingDetail } from "../api/types";

/** Rows of a part, and of the overview. */
const PART_ROWS = 15_000;
const OVERVIEW_ROWS = 4000;
/** Longer recordings stay decimated: a million rows are eight hours at 35 readings a second. */
const MAX_ROWS = 1_000_000;

/** A recording's name without the suffix of its file. */
export const recordingName = (id: string): string => id.replace(/\.pcapng$/, "");

export class RecordingData {
  detail = $state.raw<RecordingDetail | null>(null);
  columns = $state.raw(new Columns());
  /** The share that has been loaded, 0 … 1. */
  loaded = $state(0);
  /** Loading failed; the parts loaded before stay. */
  error = $state.raw<ApiError | null>(null);
  /** Counts changes of the columns. */
  tick = $state(0);

  private firstSample = $state(0);
  /** Time of the first sample; the first byte comes earlier. */
  readonly first = $derived(this.detail ? this.firstSample : 0);
  readonly last = $derived(this.detail?.last ?? 0);
  /** Too long to be loaded completely: minima and maxima are exact, steps are not samples. */
  readonly coarse = $derived((this.detail?.samples ?? 0) > MAX_ROWS);

  private reading: AbortController | null = null;
  private found = new Map<string, Extremes | undefined>();
  private readonly counted = new Map<string, Pulses>();
  private foundAt = -1;

  constructor(protected readonly api: ApiClient) {}

  get events(): readonly LineEvent[] {
    return this.detail?.events ?? [];
  }

  /** The marker of the recording `id` at this time has another name; null: it was removed. */
  marked(id: string, time: number, label: string | null): void {
    if (this.detail?.id !== id) return;
    this.detail = { ...this.detail, events: withMarker(this.detail.events, time, label) };
    this.tick += 1;
    frameClock.request();
  }

  /** The car of the recording `id` has other details. */
  described(id: string, car: Car): void {
    if (this.detail?.id === id) this.detail = { ...this.detail, car };
  }

  /** Minimum and maximum over the whole recording; undefined if it has no such channel. */
  extremes(name: string): Extremes | undefined {
    this.forget();
    if (!this.found.has(name)) this.found.set(name, extremesOf(this.columns.column(name) ?? []));
    return this.found.get(name);
  }

  /** How often a flag was set over the whole recording. */
  pulses(name: string): Pulses {
    this.forget();
    const pulses = this.counted.get(name) ?? new PulseCounter().read(this.columns, name);
    this.counted.set(name, pulses);
    return pulses;
  }

  /** Forget what was found in other data. */
  private forget(): void {
    if (this.foundAt === this.tick) return;
    this.found.clear();
    this.counted.clear();
    this.foundAt = this.tick;
  }

  /**
   * Load a recording in place of the previous one. Returns false if another load has replaced this one. Throws `ApiError` if it can't be
   * read.
   */
  protected async load(id: string): Promise<boolean> {
    this.reset();
    return this.replace(id);
  }

  /** Show what is no recording of the program, whole as it is. */
  protected adopt(detail: RecordingDetail, columns: Columns): void {
    this.reset();
    this.columns = columns;
    this.firstSample = detail.first ?? 0;
    this.detail = detail;
    this.loaded = 1;
    this.tick += 1;
  }

  /** Load the recording again: the catalog that decodes it has changed. Until then, or if it can't be read, what is shown stays. */
  async reload(): Promise<void> {
    if (this.detail === null) return;
    this.reading?.abort();
    try {
      await this.replace(this.detail.id);
    } catch (error) {
      if (error instanceof ApiError) this.error = error;
      throw error;
    }
  }

  private async replace(id: string): Promise<boolean> {
    const reading = new AbortController();
    this.reading = reading;
    const detail = await unlessAborted(reading.signal, () => this.api.recording(id));
    if (!detail) return false;
    const { first, last } = spanOf(detail);
    const query = { from: detail.first, to: detail.last, points: OVERVIEW_ROWS };
    const overview = await unlessAborted(reading.signal, () => this.api.rows(id, query, reading.signal));
    if (!overview) return false;
    const columns = columnsOf(OVERVIEW_ROWS * 2);
    columns.append(overview.names, overview.times, overview.values);
    if (overview.decimated) columns.spacing = (4 * (last - first)) / Math.max(1, columns.length);
    this.columns = columns;
    this.firstSample = Math.max(first, overview.times[0] ?? first);
    this.detail = detail;
    this.error = null;
    this.tick += 1;
    const partly = overview.decimated && !this.coarse;
    this.loaded = partly ? 0 : 1;
    if (partly) void this.read(id, detail, reading.signal);
    return true;
  }

  protected reset(): void {
    this.reading?.abort();
    this.reading = null;
    this.detail = null;
    this.loaded = 0;
    this.error = null;
    this.columns = new Columns();
    this.tick += 1;
  }

  private async read(id: string, detail: RecordingDetail, signal: AbortSignal): Promise<void> {
    const samples = detail.samples ?? 0;
    const { first, last } = spanOf(detail);
    const whole = columnsOf(samples);
    const length = Math.max(1e-6, last - first);
    const rate = Math.max(detail.rate ?? 0, samples / length);
    // Parts by time. Where samples are denser than average the server would decimate a part: it is requested again in halves.
    let seconds = Math.max(1, PART_ROWS / Math.max(1, rate));
    let from = first;
    try {
      while (from <= last) {
        const to = Math.min(from + seconds, last + 1);
        const query = { from, to, points: PART_ROWS * 1.3 };
        const rows = await unlessAborted(signal, () => this.api.rows(id, query, signal));
        if (!rows) return;
        if (rows.decimated && seconds > 0.5) {
          seconds /= 2;
          continue;
        }
        whole.append(rows.names, rows.times, rows.values);
        from = to + 1e-6;
        this.loaded = Math.min(1, (from - first) / length);
      }
      this.columns = whole;
      this.loaded = 1;
      this.tick += 1;
      frameClock.request();
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.error = error;
    }
  }
}

/** Undefined if the signal was aborted before or during the job. */
async function unlessAborted<T>(signal: AbortSignal, job: () => Promise<T>): Promise<T | undefined> {
  if (signal.aborted) return undefined;
  try {
    const done = await job();
    return signal.aborted ? undefined : done;
  } catch (error) {
    if (signal.aborted) return undefined;
    throw error;
  }
}

/** Times of the first and last byte; a recording without a packet has none. */
const spanOf = ({ first, last }: RecordingDetail) => ({ first: first ?? 0, last: last ?? 0 });

const columnsOf = (rows: number): Columns => new Columns(Math.max(16, Math.ceil(rows * 1.1) + 16));

/** The events with a marker at this time, in the place of one that is there already; `label` null: without one. */
export function withMarker(events: RecordingDetail["events"], time: number, label: string | null): RecordingDetail["events"] {
  const others = events.filter((event) => event.kind !== "marker" || event.time !== time);
  if (label === null) return others;
  const at = others.findIndex((event) => event.time > time);
  others.splice(at < 0 ? others.length : at, 0, { kind: "marker", time, label });
  return others;
}
