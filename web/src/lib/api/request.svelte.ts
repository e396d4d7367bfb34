// A request to the server with its state: the last value, the last error, whether a request is running. Of several overlapping requests
// only the last one counts.
import { ApiError } from "./http";

export class ApiRequest<T> {
  value = $state.raw<T | null>(null);
  error = $state.raw<ApiError | null>(null);
  busy = $state(false);
  private last = 0;

  /** Run the request. Undefined if it failed (then `error` is set) or a later one has replaced it. */
  async run(job: () => Promise<T>): Promise<T | undefined> {
    const own = ++this.last;
    this.busy = true;
    try {
      const value = await job();
      if (own !== this.last) return undefined;
      this.value = value;
      this.error = null;
      return value;
    } catch (error) {
      if (error instanceof DOMException && error.name === "AbortError") return undefined;
      if (!(error instanceof ApiError)) throw error;
      if (own === this.last) this.error = error;
      return undefined;
    } finally {
      if (own === this.last) this.busy = false;
    }
  }

  /** Ignore a running request when it ends. */
  protected skip(): void {
    this.last++;
    this.busy = false;
  }

  /** Return to the initial state; a running request is ignored when it ends. */
  reset(): void {
    this.skip();
    this.value = null;
    this.error = null;
  }
}
