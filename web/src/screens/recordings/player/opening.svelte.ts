// Opens a recording: the player replaces the live data, and Live shows it.
import { ApiError } from "../../../lib/api/http";
import type { Recording } from "../../../lib/api/types";
import type { Player } from "../../../lib/recording/player.svelte";
import type { Route } from "../../../lib/frame/router.svelte";

export class Opener {
  /** The recording being opened. */
  id = $state<string | null>(null);
  error = $state.raw<ApiError | null>(null);

  constructor(
    private readonly player: Player,
    private readonly route: Route,
  ) {}

  async open(recording: Recording): Promise<void> {
    this.id = recording.id;
    this.error = null;
    try {
      await this.player.open(recording.id);
      if (this.player.detail?.id === recording.id) this.route.go("live");
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.error = error;
    } finally {
      this.id = null;
    }
  }
}
