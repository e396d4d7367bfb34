// The page's end of one worker: requests and sockets of the page as messages. Nothing is sent before the program has started.
import { Deferred } from "../deferred";
import { Exchange } from "./exchange";
import type { Broken, FromWorker, Headers as Pairs, Progress, Situation, ToWorker } from "./messages";
import { WorkerSocket } from "./workerSocket";

/** What is needed of a Worker. */
export interface Port {
  postMessage(message: ToWorker, transfer: Transferable[]): void;
  onmessage: ((event: MessageEvent<FromWorker>) => void) | null;
  onerror: ((event: ErrorEvent) => void) | null;
  terminate(): void;
}

/** There is no program: as without a network, and why. */
export class ProgramEnded extends TypeError {
  constructor(
    message: string,
    readonly why: Broken["why"],
  ) {
    super(message);
  }
}

interface Conversation {
  receive(message: FromWorker): void;
  lose(message: string): void;
}

export class Endpoint {
  private readonly start = new Deferred<void>();
  /** Kept when the program answers; broken with its message when it can't. */
  readonly ready = this.start.promise;
  /** Why there is no program any more; null: it runs or starts. */
  ended: string | null = null;
  /** Whether the program has answered at all. */
  started = false;
  onprogress: ((progress: Progress) => void) | null = null;
  /** Called when nothing is asked of the program any more. */
  onidle: (() => void) | null = null;
  /** Called when a program that ran has ended. */
  onended: ((message: string) => void) | null = null;
  private last = 0;
  private readonly conversations = new Map<number, Conversation>();
  private readonly post = (message: ToWorker, transfer: Transferable[] = []) => {
    if (this.ended === null) this.port.postMessage(message, transfer);
  };

  constructor(private readonly port: Port) {
    this.ready.catch(() => undefined); // those who wait are told, nobody has to
    port.onmessage = ({ data }) => this.receive(data);
    // Later it is an error that the worker survives; one that it does not survive is a message.
    port.onerror = (event) => this.started || this.end(event.message || "the worker could not be loaded");
  }

  async fetch(address: string, init: RequestInit = {}): Promise<Response> {
    const signal = init.signal ?? null;
    signal?.throwIfAborted();
    const body = init.body == null ? null : await new Response(init.body).arrayBuffer();
    await this.ready;
    signal?.throwIfAborted();
    if (this.ended !== null) throw new TypeError(this.ended);
    const id = ++this.last;
    const exchange = new Exchange(id, this.post, signal, () => this.over(id));
    this.conversations.set(id, exchange);
    const headers: Pairs = [...new Headers(init.headers)];
    this.post({ kind: "request", id, method: init.method ?? "GET", path: pathOf(address), headers, body }, body ? [body] : []);
    return exchange.response;
  }

  connect(address: string): WorkerSocket {
    const id = ++this.last;
    const socket = new WorkerSocket(() => this.over(id));
    this.conversations.set(id, socket);
    this.ready.then(
      () => (this.ended === null ? this.post({ kind: "open", id, path: pathOf(address) }) : socket.lose(this.ended)),
      (reason: Error) => socket.lose(reason.message),
    );
    return socket;
  }

  tell(situation: Situation): void {
    this.ready.then(
      () => this.post({ kind: "situation", ...situation }),
      () => undefined,
    );
  }

  /** Let the adapters go while the page is not shown, or have them again. A worker that starts has none yet. */
  release(gone: boolean): void {
    if (this.started) this.post({ kind: "release", gone });
  }

  /** Whether something is asked of the program, and not yet answered to its end. */
  get busy(): boolean {
    return this.conversations.size > 0;
  }

  /** End the program at once; what is kept stays kept. */
  terminate(): void {
    this.end("ended by the page");
  }

  private over(id: number): void {
    if (this.conversations.delete(id) && !this.busy) this.onidle?.();
  }

  private receive(message: FromWorker): void {
    if (message.kind === "progress") this.onprogress?.(message);
    else if (message.kind === "ready") {
      this.started = true;
      this.start.keep();
    } else if (message.kind === "broken") this.end(message.message, message.why);
    else this.conversations.get(message.id)?.receive(message);
  }

  private end(message: string, why?: Broken["why"]): void {
    if (this.ended !== null) return;
    this.ended = message;
    this.port.terminate(); // its memory is needed, and it has the cable
    this.start.fail(new ProgramEnded(message, why));
    for (const conversation of [...this.conversations.values()]) conversation.lose(message);
    if (this.started) this.onended?.(message);
  }
}

/** The program's own path of an address that is relative to the page. */
const pathOf = (address: string): string => `/${address.replace(/^\/+/, "")}`;
