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
  name(time: number, label: string, id: string | null): Promise<boolean> {
    return this.mark(time, label, id, () => this.app.api.nameMarker(id, time, label));
  }

  /** Remove a marker of live data, or of the recording `id`. Returns whether that succeeded. */
  remove(time: number, id: string | null): Promise<boolean> {
    return this.mark(time, null, id, () => this.app.api.removeMarker(id, time));
  }

  private async mark(time: number, label: string | null, id: string | null, change: () => Promise<unknown>): Promise<boolean> {
    if ((await this.app.toasts.attempt(change)) === undefined) return false;
    if (id !== null) this.app.player.marked(id, time, label);
    return true;
  }
}
