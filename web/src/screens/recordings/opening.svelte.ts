// Opening a recording: the player puts it in the place of the live line, Live shows it, and the bar below plays it.
import { ApiError } from "../../lib/api";
import { player } from "../../lib/player.svelte";
import { route } from "../../lib/router.svelte";
import type { Recording } from "../../lib/types";

class Opener {
  /** What is being opened. */
  id = $state<string | null>(null);
  error = $state.raw<ApiError | null>(null);

  async open(recording: Recording): Promise<void> {
    this.id = recording.id;
    this.error = null;
    try {
      await player.open(recording.id);
      if (player.detail?.id === recording.id) route.go("live");
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.error = error;
    } finally {
      this.id = null;
    }
  }
}

export const opener = new Opener();
