// The causes of the connected car or of a recording. Another complaint ranks the same data again; a guided test that has ended does, too.
import { Resource } from "../../lib/api/resource.svelte";
import type { Causes, Complaint } from "../../lib/api/types";
import type { Stores } from "../../stores";
import { reportSource } from "../report/address";

/** ms between two rankings of the connected car. */
const EVERY = 30_000;

export class CauseStore {
  /** What the owner complains of. */
  complaint = $state<Complaint | null>(null);
  readonly ranking: Resource<{ of: string | null }, Causes>;

  constructor(private readonly app: Pick<Stores, "api" | "cursors" | "display" | "live" | "player" | "route" | "tests" | "view">) {
    this.ranking = new Resource({
      of: () => (this.possible && app.live.link === "open" ? { of: this.chosen } : null),
      again: () => [this.complaint, this.chosen === null ? (app.tests.results.value?.results[0]?.id ?? null) : null],
      ask: ({ of }, signal) => app.api.causes(of, this.complaint, signal),
      every: () => (this.chosen === null ? EVERY : 0),
    });
  }

  /** The recording that is looked at; null: the connected car. Without a choice: what is shown on the other screens. */
  get chosen(): string | null {
    const { display, player, route } = this.app;
    const open = display.source.kind === "recording" ? (player.detail?.id ?? null) : null;
    return reportSource(route.screen === "causes" ? route.rest[0] : undefined, open);
  }

  get possible(): boolean {
    const { state } = this.app.live;
    return this.chosen !== null || (state !== null && state.line !== "off");
  }

  /** Choose a complaint; the same again takes it back. */
  complain(complaint: Complaint): void {
    this.complaint = this.complaint === complaint ? null : complaint;
  }

  /** Show a moment between the cursors of the chart: of its recording, or of the live data. */
  async show(recording: string | null, { begin, end }: { begin: number; end: number }): Promise<void> {
    const { cursors, display, player, route, view } = this.app;
    if (recording === null) {
      if (display.source.kind === "recording") player.close();
    } else {
      if (player.detail?.id !== recording || display.source.kind !== "recording") await player.open(recording);
      player.pause();
      player.seek(begin);
    }
    [cursors.a, cursors.b] = [begin, end];
    view.bringMoment({ from: begin, to: end });
    route.go("chart");
  }
}
