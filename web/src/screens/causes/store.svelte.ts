// The causes of the connected car, or of a recording or several of one car. Another complaint ranks the same data again; a guided test that has ended does, too.
import { Resource } from "../../lib/api/resource.svelte";
import type { Causes, Complaint } from "../../lib/api/types";
import type { Stores } from "../../stores";
import { sourceOf } from "../../lib/recording/source";
import { newestFirst } from "../../lib/recording/order";

/** ms between two rankings of the connected car. */
const EVERY = 30_000;

export class CauseStore {
  /** What the owner complains of. */
  complaint = $state<Complaint | null>(null);
  readonly ranking: Resource<{ of: string | null; together: string[] }, Causes>;

  constructor(
    private readonly app: Pick<Stores, "api" | "cursors" | "display" | "live" | "player" | "recordings" | "route" | "tests" | "view">,
  ) {
    this.ranking = new Resource({
      of: () => (this.possible && app.live.link === "open" ? { of: this.chosen, together: this.together } : null),
      again: () => [this.complaint, this.chosen === null ? (app.tests.results.value?.results[0]?.id ?? null) : null],
      ask: ({ of, together }, signal) => app.api.causes(of, together, this.complaint, signal),
      every: () => (this.chosen === null ? EVERY : 0),
    });
  }

  /**
   * The recording that is looked at; null: the connected car. Without a choice: what is shown on the other screens, and with no car connected
   * the newest recording.
   */
  get chosen(): string | null {
    const { display, live, player, recordings, route } = this.app;
    const open = display.source.kind === "recording" ? (player.detail?.id ?? null) : null;
    const asked = route.screen === "causes" ? route.rest[0] : undefined;
    const newest = newestFirst(recordings.list.value ?? []).find((it) => !it.virtual && it.samples !== 0);
    return sourceOf(asked, open ?? (this.connected || live.state === null ? null : (newest?.id ?? null)));
  }

  /** The other recordings of the car that count with it. */
  get together(): string[] {
    const { route } = this.app;
    return this.chosen !== null && route.screen === "causes" ? route.rest.slice(1) : [];
  }

  get possible(): boolean {
    return this.chosen !== null || this.connected;
  }

  private get connected(): boolean {
    const { state } = this.app.live;
    return state !== null && state.line !== "off";
  }

  /** Choose a complaint; the same again takes it back. */
  complain(complaint: Complaint): void {
    this.complaint = this.complaint === complaint ? null : complaint;
  }

  /** Show a moment between the cursors of the chart: of its recording, or of the live data. */
  async show(recording: string | null, { begin, end }: { begin: number; end: number }): Promise<void> {
    const { cursors, display, player, route, view } = this.app;
    const go = route.later();
    if (recording === null) {
      if (display.source.kind === "recording") player.close();
    } else {
      if (player.detail?.id !== recording || display.source.kind !== "recording") await player.open(recording);
      player.pause();
      player.seek(begin);
    }
    [cursors.a, cursors.b] = [begin, end];
    view.bringMoment({ from: begin, to: end });
    go("chart");
  }
}
