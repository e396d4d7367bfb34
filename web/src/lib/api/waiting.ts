// Requests that wait for their answers. A network that has gone closes no connection: the browser would wait for a quarter of an hour, and a
// button with it. So a request that was there when the live connection was lost is given up, if its answer does not come soon.
import type { RequestOptions } from "./http";

/** ms after the loss. Most answers take less, and one that a short loss has only delayed has come by then. */
const PATIENCE = 15_000;

interface Request {
  readonly stop: AbortController;
  /** It may take long by itself: it is given up only while the connection is lost. */
  readonly long: boolean;
  /** ms since the loss; null: there was none. */
  waited: number | null;
}

export class Waiting {
  private readonly requests = new Set<Request>();

  /** What `ask` returns, which has to heed the signal that it gets, and to call `came` with each part of a long answer. */
  async wait<T>(
    { signal, long = false }: Pick<RequestOptions, "signal"> & { long?: boolean },
    ask: (signal: AbortSignal, came: () => void) => Promise<T>,
  ): Promise<T> {
    signal?.throwIfAborted();
    const request: Request = { stop: new AbortController(), long, waited: null };
    const stop = () => request.stop.abort(signal?.reason);
    signal?.addEventListener("abort", stop);
    this.requests.add(request);
    try {
      return await ask(request.stop.signal, () => (request.waited = null));
    } finally {
      this.requests.delete(request);
      signal?.removeEventListener("abort", stop);
    }
  }

  /** Look after so many ms more whether the connection is `lost`, and give up what has waited too long since. */
  look(lost: boolean, ms: number): void {
    for (const request of this.requests) {
      if (lost) request.waited = (request.waited ?? 0) + ms;
      else if (request.long) request.waited = null;
      else if (request.waited !== null) request.waited += ms;
      if (request.waited !== null && request.waited >= PATIENCE) {
        request.stop.abort(new DOMException("The program does not answer.", "TimeoutError"));
      }
    }
  }
}
