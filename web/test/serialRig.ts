// A port for the tests of the worker's serial side.
import { SerialHost, type OpenPort } from "../src/site/worker/serial";
import type { SerialPort } from "../src/site/worker/webSerial";

/** A port as the browser has it: a stream of bytes that errors end, after which there may be a new one. */
export class FakePort extends EventTarget implements SerialPort {
  connected = true;
  readable: ReadableStream<Uint8Array> | null = null;
  writable: WritableStream<Uint8Array> | null = null;
  opened: unknown[] = [];
  signals: unknown[] = [];
  written: number[] = [];
  closed = 0;
  /** What the port has instead of a hand that takes bytes. */
  takes: Promise<void> = Promise.resolve();
  refuses: Error | undefined;
  refusesSignals = false;
  private controller: ReadableStreamDefaultController<Uint8Array> | undefined;

  constructor(readonly info: { usbVendorId?: number; usbProductId?: number } = { usbVendorId: 0x0403, usbProductId: 0x6001 }) {
    super();
  }

  getInfo = () => this.info;

  async open(options: unknown): Promise<void> {
    if (this.refuses) throw this.refuses;
    this.opened.push(options);
    this.newStream();
    this.writable = new WritableStream({ write: (chunk) => (this.written.push(...chunk), this.takes) });
  }

  async setSignals(signals: unknown): Promise<void> {
    if (this.refusesSignals) throw new DOMException("Failed to set control signals.", "NetworkError");
    this.signals.push(signals);
  }

  async close(): Promise<void> {
    if (this.readable?.locked || this.writable?.locked) throw new TypeError("Cannot cancel a locked stream");
    this.closed += 1;
    this.readable = this.writable = null;
  }

  send(...bytes: number[]): void {
    this.controller?.enqueue(new Uint8Array(bytes));
  }

  fail(name: string, fatal: boolean): void {
    const old = this.controller;
    if (fatal) this.readable = null;
    else this.newStream();
    old?.error(new DOMException(`it was ${name}`, name));
  }

  private newStream(): void {
    this.readable = new ReadableStream({ start: (controller) => void (this.controller = controller) });
  }
}

export const hostOf = (...ports: SerialPort[]) => new SerialHost(Object.assign(new EventTarget(), { getPorts: async () => ports }));
export const python = (...bytes: number[]) => ({ toJs: () => new Uint8Array(bytes) });

export async function opened(port = new FakePort(), dtr = true, rts = false): Promise<OpenPort> {
  const host = hostOf(port);
  const [granted] = await host.ports().promise;
  return (await host.open(granted!, 9600, dtr, rts).promise) as OpenPort;
}
