// Opens a recording: the player replaces the live data, and Live shows it.
import { ApiError } from "../../../lib/api/http";
import { player } from "../../../lib/recording/player.svelte";
import { route } from "../../../lib/frame/router.svelte";
import type { Recording } from "../../../lib/api/types";

class Opener {
  /** The recording being opened. */
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
