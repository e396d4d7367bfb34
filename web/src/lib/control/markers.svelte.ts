// Markers: the one that was just set and can be named at once; named, removed and brought back later, of live data and of recordings.
import type { LineEvent } from "../api/types";
import type { Stores } from "../../stores";

export interface Mark {
  time: number;
  label: string;
}

/** The markers among the events, in the order of their times. */
export function markersOf(events: readonly LineEvent[]): Mark[] {
  return events
    .flatMap((event) => (event.kind === "marker" ? [{ time: event.time, label: event.label }] : []))
    .sort((one, other) => one.time - other.time);
}

/** The next marker after a time, or the previous one; wraps around at the ends. */
export function nextMark(marks: readonly Mark[], time: number, step: 1 | -1): Mark | undefined {
  if (step > 0) return marks.find((mark) => mark.time > time + 1e-3) ?? marks[0];
  return marks.findLast((mark) => mark.time < time - 1e-3) ?? marks.at(-1);
}

export class Naming {
  /** The marker that was just set; null: none, or its name has been given. */
  marker = $state.raw<{ time: number; recorded: boolean } | null>(null);

  constructor(private readonly app: Pick<Stores, "api" | "player" | "toasts">) {}

  /** Give a marker of live data, or of the recording `id`, another name; a removed one comes back. Returns whether that succeeded. */
  async name(time: number, label: string, id: string | null): Promise<boolean> {
    if (id === null) return (await this.app.toasts.attempt(() => this.app.api.nameMarker(time, label))) !== undefined;
    if ((await this.app.toasts.attempt(() => this.app.api.nameRecordedMarker(id, time, label))) === undefined) return false;
    this.app.player.marked(id, time, label);
    return true;
  }

  /** Remove a marker of live data, or of the recording `id`. Returns whether that succeeded. */
  async remove(time: number, id: string | null): Promise<boolean> {
    if (id === null) return (await this.app.toasts.attempt(() => this.app.api.removeMarker(time))) !== undefined;
    if ((await this.app.toasts.attempt(() => this.app.api.removeRecordedMarker(id, time))) === undefined) return false;
    this.app.player.marked(id, time, null);
    return true;
  }
}
