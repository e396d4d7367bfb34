// Something asked of the server: what came, or why not, and whether it is on its way. Of several askings the last one counts.
import { ApiError } from "./api";

export class Asked<T> {
  value = $state.raw<T | null>(null);
  error = $state.raw<ApiError | null>(null);
  busy = $state(false);
  private last = 0;

  /** Undefined if it failed (then `error` says why), or if something else was asked meanwhile. */
  async ask(job: () => Promise<T>): Promise<T | undefined> {
    const mine = ++this.last;
    this.busy = true;
    try {
      const value = await job();
      if (mine !== this.last) return undefined;
      this.value = value;
      this.error = null;
      return value;
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      if (mine === this.last) this.error = error;
      return undefined;
    } finally {
      if (mine === this.last) this.busy = false;
    }
  }

  /** As at the beginning; what is still on its way comes to nothing. */
  forget(): void {
    this.last++;
    this.value = null;
    this.error = null;
    this.busy = false;
  }
}
