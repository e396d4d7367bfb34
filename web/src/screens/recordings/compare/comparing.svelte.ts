// Selecting a second recording to compare with: for the one being played, or for one of the list, which is opened first.
import { ApiError } from "../../../lib/api/http";
import type { Text } from "../../../lib/api/types";
import type { ForeignLog } from "../../../lib/recording/foreign";
import type { Stores } from "../../../stores";

export class Comparing {
  /** The recording for which a second one is being selected. */
  first = $state<string | null>(null);
  /** The second recording while it is being opened. */
  busy = $state<string | null>(null);
  error = $state.raw<ApiError | null>(null);
  /** Another program's log, whose columns are being chosen. */
  file = $state.raw<File | null>(null);
  private turn = 0;

  constructor(private readonly app: Pick<Stores, "comparison" | "player" | "route">) {}

  choose(first: string): void {
    this.error = null;
    this.first = first;
  }

  /** Also of one that is being opened: it is not shown then. */
  stop(): void {
    this.turn += 1;
    if (this.busy !== null) this.app.comparison.end();
    this.busy = null;
    this.first = null;
    this.file = null;
    this.error = null;
  }

  /** Open the comparison with another program's log. If the first recording can't be read, the dialog shows the error. */
  beginForeign(first: string, log: ForeignLog): Promise<void> {
    this.file = null;
    return this.open(first, log.detail.id, () => {
      this.app.comparison.startForeign(log, this.app.player.first);
      return true;
    });
  }

  /** Open the comparison. If a recording can't be read, the dialog shows the error and stays open. */
  begin(first: string, second: string, named: Text | null = null): Promise<void> {
    return this.open(first, second, () => this.app.comparison.start(second, this.app.player.first, named));
  }

  private async open(first: string, second: string, start: () => boolean | Promise<boolean>): Promise<void> {
    const turn = ++this.turn;
    const go = this.app.route.later();
    this.busy = second;
    this.error = null;
    try {
      if (this.app.player.detail?.id !== first) await this.app.player.open(first);
      if (turn !== this.turn || this.app.player.detail?.id !== first) return;
      if (!(await start()) || turn !== this.turn) return;
      this.first = null;
      if (this.app.route.screen !== "chart") go("chart");
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      if (turn !== this.turn) return;
      this.error = error;
      this.first = first;
    } finally {
      if (turn === this.turn) this.busy = null;
    }
  }
}
