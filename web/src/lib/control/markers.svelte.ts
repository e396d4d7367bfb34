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
  /** The marker that was just set; null: none, or its name has been given. `id`: in that recording; null: of live data. */
  marker = $state.raw<{ time: number; recorded: boolean; id: string | null } | null>(null);

  constructor(private readonly app: Pick<Stores, "api" | "cursors" | "live" | "player" | "route" | "toasts">) {}

  /** Mark this moment of what is shown, live or in a recording, where a chart's cursor stands or the player; its name can follow. */
  async here(): Promise<void> {
    const { cursors, player, route } = this.app;
    if (player.shown === null) return this.now();
    const { id } = player.shown;
    const cursor = route.screen === "chart" && !player.playing ? cursors.a : null;
    const [set] = await this.place([{ time: cursor ?? player.position, label: "" }]);
    if (set) this.marker = { time: set.time, recorded: true, id };
  }

  /** Mark this moment of live data. */
  async now(): Promise<void> {
    const recorded = this.app.live.state?.recording != null;
    const set = await this.app.toasts.attempt(() => this.app.api.marker(""));
    if (set) this.marker = { time: set.time, recorded, id: null };
  }

  /** Set markers in what is shown, live or a recording, and return those that were set. */
  async place(marks: readonly Mark[]): Promise<readonly Mark[]> {
    const { api, player, toasts } = this.app;
    if (player.shown === null) {
      const set: Mark[] = [];
      for (const { time, label } of marks) {
        const made = await toasts.attempt(() => api.marker(label, time));
        if (!made) break;
        set.push({ time: made.time, label });
      }
      return set;
    }
    const { id } = player.shown;
    const made = await toasts.attempt(() => api.markRecording(id, marks));
    for (const { time, label } of made?.markers ?? []) player.marked(id, time, label);
    return made?.markers ?? [];
  }

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
