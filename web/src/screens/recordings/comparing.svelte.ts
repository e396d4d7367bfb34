// Choosing a second recording: for the one that is played, or for one of the list, which is opened first. Shown by the frame, in the chart.
import { ApiError } from "../../lib/api/http";
import { comparison } from "../../lib/recording/comparison.svelte";
import { player } from "../../lib/recording/player.svelte";
import { route } from "../../lib/view/router.svelte";

class Comparing {
  /** For which recording a second one is being chosen. */
  first = $state<string | null>(null);
  /** The second one, while it is being opened. */
  busy = $state<string | null>(null);
  error = $state.raw<ApiError | null>(null);

  choose(first: string): void {
    this.error = null;
    this.first = first;
  }

  stop(): void {
    this.first = null;
    this.error = null;
  }

  /** Draws it beside the first one; if it can't be read, the sheet says why, and another may be chosen. */
  async begin(first: string, second: string): Promise<void> {
    this.busy = second;
    this.error = null;
    try {
      if (player.detail?.id !== first) await player.open(first);
      if (player.detail?.id !== first || !(await comparison.start(second, player.first))) return;
      this.first = null;
      route.go("chart");
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.error = error;
      this.first = first;
    } finally {
      if (this.busy === second) this.busy = null;
    }
  }
}

export const comparing = new Comparing();
