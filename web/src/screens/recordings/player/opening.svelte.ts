// Opens a recording: the player replaces the live data, and Live shows it.
import { ApiError } from "../../../lib/api/http";
import type { Recording } from "../../../lib/api/types";
import type { Stores } from "../../../stores";

export class Opener {
  /** The recording being opened. */
  id = $state<string | null>(null);
  error = $state.raw<ApiError | null>(null);

  constructor(private readonly app: Pick<Stores, "player" | "route">) {}

  async open(recording: Recording): Promise<void> {
    this.id = recording.id;
    this.error = null;
    try {
      await this.app.player.open(recording.id);
      if (this.app.player.detail?.id === recording.id) this.app.route.go("live");
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.error = error;
    } finally {
      this.id = null;
    }
  }
}
