// What has come from the wire, as the streams that a SerialPort has: an error of the line ends its stream, and there is a new one at once. Nothing
// that came before an error is lost, as a stream would lose it: chunks wait here until they are read, never in a stream.
import type { LineError } from "./chips/chip";

type Stream = ReadableStream<Uint8Array>;
type Controller = ReadableStreamDefaultController<Uint8Array>;

/** What ends a stream; `fatal`: there is no next one. */
interface End {
  readonly error: DOMException;
  readonly fatal: boolean;
}

export class Incoming {
  /** Null: the port is closed, or lost and all that came before is read. */
  readable: Stream | null;
  private current: Controller | undefined;
  private readonly waiting: (Uint8Array | End)[] = [];
  private bytes = 0;
  private isOver = false;
  private wake: () => void = () => undefined;

  /** `limit`: so many bytes wait at most; of what comes then, nothing is kept. */
  constructor(private readonly limit: number) {
    this.readable = this.next();
  }

  add(bytes: Uint8Array): void {
    if (this.isOver || !bytes.length) return;
    if (this.bytes + bytes.length > this.limit) return this.fail("BufferOverrunError");
    this.bytes += bytes.length;
    this.waiting.push(bytes);
    this.wake();
  }

  /** The wire had an error; of like ones in a row the first one is kept. */
  fail(name: LineError): void {
    const last = this.waiting.at(-1);
    if (this.isOver || (last && "error" in last && last.error.name === name)) return;
    this.waiting.push({ error: new DOMException(`The chip reports a ${name}.`, name), fatal: false });
    this.wake();
  }

  /** The port is gone. */
  lose(error: DOMException): void {
    if (this.isOver) return;
    this.isOver = true;
    this.waiting.push({ error, fatal: true });
    this.wake();
  }

  /** The port is closed here. */
  close(): void {
    this.readable = null;
    this.isOver = true;
    this.waiting.length = 0;
    this.wake();
  }

  private next(): Stream {
    let own: Controller;
    return new ReadableStream<Uint8Array>(
      {
        start: (controller) => void (own = this.current = controller),
        pull: (controller) => this.give(controller),
        cancel: () => {
          if (this.current === own && this.readable) this.readable = this.next();
        },
      },
      { highWaterMark: 0 },
    );
  }

  /** Give the next chunk or error to whoever reads. A pull that gives nothing is not repeated, so this one waits. */
  private async give(controller: Controller): Promise<void> {
    while (!this.waiting.length && !this.isOver && this.current === controller) await new Promise<void>((wake) => (this.wake = wake));
    if (this.current !== controller) return;
    const it = this.waiting.shift();
    if (it === undefined) return controller.close();
    if (!("error" in it)) {
      this.bytes -= it.length;
      return controller.enqueue(it);
    }
    // Before the stream ends: who looks for the next one would take this one again for ever.
    this.readable = it.fatal ? null : this.next();
    controller.error(it.error);
  }
}
