// One request to the program in a worker, and the Response made of its answer. As with `fetch`, the promise is kept with the head of the
// answer, and the body follows as a stream.
import { Deferred } from "../deferred";
import type { FromWorker, ToWorker } from "./messages";

/** Statuses whose responses must have no body. */
const EMPTY = new Set([204, 205, 304]);

export interface Post {
  (message: ToWorker, transfer?: Transferable[]): void;
}

export class Exchange {
  private readonly answer = new Deferred<Response>();
  readonly response = this.answer.promise;
  private body: ReadableStreamDefaultController<Uint8Array<ArrayBuffer>> | null = null;
  private readonly aborted = () => {
    this.post({ kind: "abort", id: this.id });
    this.fail(this.signal?.reason);
  };

  /** `over` is called once, when nothing can follow. */
  constructor(
    private readonly id: number,
    private readonly post: Post,
    private readonly signal: AbortSignal | null,
    private readonly over: () => void,
  ) {
    signal?.addEventListener("abort", this.aborted);
  }

  receive(message: FromWorker): void {
    if (message.kind === "head") this.begin(message.status, message.headers);
    else if (message.kind === "body") this.body?.enqueue(message.data);
    else if (message.kind === "end") {
      this.body?.close();
      this.end();
    } else if (message.kind === "failed") this.fail(new TypeError(message.message));
  }

  /** The worker has ended. */
  lose(message: string): void {
    this.fail(new TypeError(message));
  }

  private begin(status: number, headers: [string, string][]): void {
    const body = new ReadableStream<Uint8Array<ArrayBuffer>>({
      start: (controller) => void (this.body = controller),
      cancel: () => {
        this.post({ kind: "abort", id: this.id });
        this.body = null;
        this.end();
      },
    });
    this.answer.keep(new Response(EMPTY.has(status) ? null : body, { status, headers }));
  }

  private fail(reason: unknown): void {
    this.answer.fail(reason);
    this.body?.error(reason);
    this.end();
  }

  private end(): void {
    this.signal?.removeEventListener("abort", this.aborted);
    this.over();
  }
}
