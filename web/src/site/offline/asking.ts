// The service worker's end of a download: it asks the page that has the program, by a message port. As far as the browser wants more of the
// file, the page is asked for more: a file never waits in memory.

import { Deferred } from "../deferred";

export type FromPage =
  /** This page has the program, and answers. */
  | { kind: "here" }
  | { kind: "head"; status: number; headers: [string, string][] }
  | { kind: "part"; data: Uint8Array<ArrayBuffer> }
  | { kind: "end" }
  | { kind: "failed" };
export type ToPage = { kind: "more" } | { kind: "stop" };
export interface Asked {
  kind: "request";
  /** Relative to the page. */
  address: string;
}

/** What is needed of a page. */
export interface Page {
  postMessage(message: Asked, transfer: Transferable[]): void;
}

/** ms in which the page that has the program says so. */
const HERE_MS = 3000;

const NOBODY = "Open mikas first, then this address. Сначала откройте mikas, затем этот адрес.";

/** The answer of the page that has the program, and when it has ended. */
export async function askPages(pages: readonly Page[], address: string): Promise<{ response: Response; over: Promise<void> }> {
  const answers = pages.map((page) => new Answer(page, address));
  let timer: ReturnType<typeof setTimeout> | undefined;
  const late = new Promise<never>((_, fail) => (timer = setTimeout(() => fail(new Error("late")), HERE_MS)));
  try {
    const here = await Promise.race([Promise.any(answers.map(({ here }) => here.promise)), late]);
    return { response: await here.response.promise, over: here.over.promise };
  } catch {
    return { response: text(503, NOBODY), over: Promise.resolve() };
  } finally {
    clearTimeout(timer);
  }
}

const text = (status: number, words: string): Response =>
  new Response(words, { status, headers: { "Content-Type": "text/plain; charset=utf-8" } });

class Answer {
  readonly here = new Deferred<Answer>();
  readonly response = new Deferred<Response>();
  readonly over = new Deferred<void>();
  private body: ReadableStreamDefaultController<Uint8Array<ArrayBuffer>> | null = null;
  private readonly port: MessagePort;

  constructor(page: Page, address: string) {
    const channel = new MessageChannel();
    this.port = channel.port1;
    this.port.onmessage = ({ data }: MessageEvent<FromPage>) => this.receive(data);
    page.postMessage({ kind: "request", address }, [channel.port2]);
  }

  private receive(message: FromPage): void {
    if (message.kind === "here") this.here.keep(this);
    else if (message.kind === "head") this.begin(message.status, message.headers);
    else if (message.kind === "part") this.body?.enqueue(message.data);
    else {
      if (message.kind === "end") this.body?.close();
      else this.body?.error(new TypeError("the program has ended"));
      this.response.keep(text(502, "The program has ended. Программа завершилась."));
      this.close();
    }
  }

  private begin(status: number, headers: [string, string][]): void {
    const body = new ReadableStream<Uint8Array<ArrayBuffer>>(
      {
        start: (controller) => void (this.body = controller),
        pull: () => this.say({ kind: "more" }),
        cancel: () => {
          this.say({ kind: "stop" });
          this.close();
        },
      },
      { highWaterMark: 1 },
    );
    this.response.keep(new Response(body, { status, headers }));
  }

  private say(message: ToPage): void {
    this.port.postMessage(message);
  }

  private close(): void {
    this.body = null;
    this.port.close();
    this.over.keep();
  }
}
