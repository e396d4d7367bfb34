// The adapters on Web Serial, or on WebUSB (`../usb/`), for Python's link (`mikas.browser.web_serial`). Here runs what can't wait for Python: each chunk is stamped when
// it comes and kept until Python takes it. No promise is rejected: what went wrong is in what it is kept with, or in `lost`.
import type { Serial, SerialPort } from "./webSerial";
import { STALLS } from "../usb/session";
import { HANGS, within } from "../within";
import { Heard } from "./ahead";
import { afterOthers } from "./waits";

/** Of the browser's buffer: a minute of the line, while Python computes. By default it is 255 bytes, a quarter of a second. */
const BUFFER = 1 << 16;
/** ms; the longest that a timer takes: it has 32 bits. */
const LONGEST = 0x7fffffff;

/** s; whoever has looked for bytes so recently need not let the browser do what it has waiting: to wait is the dear part of an exchange. */
const RECENTLY = 0.003;

/** ms in which the browser settles what is asked of a port. A driver that hangs settles nothing, and Python would wait for ever. */
const PATIENCE = { list: 2000, open: 10_000, signals: 2000, close: 5000 };

/** By so much the rate that a chip makes may differ from the one that was asked for: more, and bytes are damaged. */
const TOLERANCE = 0.03;

/** Bytes of Python. */
interface PyBytes {
  toJs(): Uint8Array;
}

/** What Python waits for: a promise that a function returns would become an asyncio future there (`waits.ts`). */
interface Pending<T> {
  readonly promise: Promise<T>;
}

/** A port that the user has granted. The `nth` of its kind keeps this number until it is unplugged, whatever becomes of the others. */
export interface Granted {
  readonly port: SerialPort;
  /** The scheme of its name: `webserial` or `webusb`. */
  readonly scheme: string;
  /** USB vendor and product; undefined: not on USB. */
  readonly vid: number | undefined;
  readonly pid: number | undefined;
  /** Empty: it has none, or the browser does not say. */
  readonly serialNumber: string;
  readonly nth: number;
}

/** Why a port did not open: the name and the message of the browser's error, or `OTHER_RATE` and the rate. */
export interface Refusal {
  readonly refused: string;
  readonly message: string;
}

/** The chip makes another baud rate than was asked for. */
const OTHER_RATE = "RateError";

/** The scheme of a port that is the browser's own. */
const WEB_SERIAL = "webserial";

/** Seconds since 1970, of a clock that never runs back. */
export const now = (): number => (performance.timeOrigin + performance.now()) / 1000;

export class SerialHost {
  private granted: Granted[] = [];
  private readonly closing = new Map<SerialPort, Promise<void>>();
  private inUse: readonly OpenPort[] = [];
  private released = false;

  constructor(private readonly serial: Serial | undefined) {}

  readonly now = now;

  /** The granted ports that are plugged in. The page may have asked for a port meanwhile, of which no event tells: so it is looked up. */
  ports(): Pending<Granted[]> {
    return { promise: this.look() };
  }

  /** Open a port, 8N1, no flow control. */
  open({ port }: Granted, baudRate: number, dtr: boolean, rts: boolean): Pending<OpenPort | Refusal> {
    return { promise: this.opened(port, baudRate, dtr, rts) };
  }

  /** Let all ports go, for the page is not shown any more; or have them again. */
  release(gone: boolean): void {
    this.released = gone;
    for (const port of gone ? this.inUse : []) port.lose(UNPLUGGED);
  }

  private async look(): Promise<Granted[]> {
    if (this.released) return [];
    const listed = await within(PATIENCE.list, this.serial?.getPorts() ?? Promise.resolve([])).catch(() => null);
    if (listed === null) return this.granted;
    const present = listed.filter((port) => port.connected !== false);
    this.granted = this.granted.filter(({ port }) => present.includes(port));
    for (const port of present) {
      if (this.granted.some((known) => known.port === port)) continue;
      const { usbVendorId: vid, usbProductId: pid } = port.getInfo();
      const scheme = port.scheme ?? WEB_SERIAL;
      const like = this.granted.filter((known) => known.vid === vid && known.pid === pid && known.scheme === scheme);
      const taken = like.map(({ nth }) => nth);
      let nth = 1;
      while (taken.includes(nth)) nth += 1;
      this.granted.push({ port, scheme, vid, pid, serialNumber: port.serialNumber ?? "", nth });
    }
    return this.granted;
  }

  private async opened(port: SerialPort, baudRate: number, dtr: boolean, rts: boolean): Promise<OpenPort | Refusal> {
    try {
      await within(PATIENCE.close, this.closing.get(port) ?? Promise.resolve());
      const opened = port.open({ baudRate, bufferSize: BUFFER });
      await within(port.patience ?? PATIENCE.open, opened).catch((error: unknown) => {
        // It may open yet: then nobody has it, and it is closed.
        if (errorOf(error).name === HANGS) this.closing.set(port, closedAfter(opened, port));
        throw error;
      });
    } catch (error) {
      const { name, message } = errorOf(error);
      return { refused: name, message };
    }
    const rate = port.rate ?? baudRate;
    if (Math.abs(rate / baudRate - 1) > TOLERANCE) {
      this.closing.set(port, port.close());
      return { refused: OTHER_RATE, message: String(Math.round(rate)) };
    }
    // Not every adapter has these lines.
    await within(PATIENCE.signals, port.setSignals({ dataTerminalReady: dtr, requestToSend: rts })).catch(() => undefined);
    const it = new OpenPort(port, (closed) => this.closing.set(port, closed));
    this.inUse = [...this.inUse.filter(({ lost }) => !lost), it];
    return it;
  }
}

/** Why a port is lost, if it is not the browser's word. */
const CLOSED = "closed";
const STUCK = "stuck";
const UNPLUGGED = "unplugged";
const STALLED = "stalled";

/** A request that waits for the answer to the one before. */
interface Next {
  readonly echo: Uint8Array;
  /** Of the answer's body. */
  readonly length: number;
  readonly bytes: Uint8Array;
  readonly patience: number;
}

export class OpenPort {
  /** Why the port is gone; empty: it is open. */
  lost = "";
  /** When the last byte came of those that `take` returned. */
  takenAt = 0;
  /** s by which the chip hands bytes over late; 0: the browser does not say. */
  readonly granularity: number;

  private readonly chunks: Uint8Array[] = [];
  private readonly heard = new Heard();
  private next: Next | undefined;
  /** When `next` was written; 0: it was not. */
  private wroteNext = 0;
  /** What has come since then: Python is to know first what it follows. */
  private readonly behind: Uint8Array[] = [];
  private behindAt = 0;
  private arrivedAt = 0;
  private lookedAt = 0;
  private wake: () => void = () => undefined;
  private written: () => void = () => undefined;
  private reader: ReadableStreamDefaultReader<Uint8Array> | undefined;
  private readonly writer: WritableStreamDefaultWriter<Uint8Array> | undefined;

  constructor(
    private readonly port: SerialPort,
    private readonly closes: (closed: Promise<void>) => void,
  ) {
    this.granularity = port.granularity ?? 0;
    this.writer = port.writable?.getWriter();
    port.addEventListener("disconnect", () => this.lose(UNPLUGGED), { once: true });
    void this.listen();
  }

  /** Kept when bytes have come, the port is gone, or `deadline` (as `now`) is over; undefined: it is so. */
  arrival(deadline: number): Pending<void> | undefined {
    const isOver = deadline <= now() && now() < this.lookedAt + RECENTLY;
    return this.hasNews || isOver ? undefined : this.until(deadline, () => this.hasNews);
  }

  /** Kept when the port is gone or `time` is over; bytes come together meanwhile. */
  gathering(time: number): Pending<void> {
    return this.until(time, () => this.lost !== "");
  }

  /** All bytes that have come since the last call; undefined: none. */
  take(): Uint8Array | undefined {
    const [first, ...others] = this.chunks.splice(0);
    if (!first) return undefined;
    this.takenAt = this.arrivedAt;
    return others.length ? joined([first, ...others]) : first;
  }

  /** Kept when the browser has accepted the bytes, or the port is gone: it is if that takes longer than `patience` seconds. */
  write(data: PyBytes, patience: number): Pending<void> {
    this.takeBack();
    this.heard.begin(this.chunks);
    return { promise: this.put(data.toJs(), patience) };
  }

  /**
   * Write `data` as soon as the answer to the latest request is whole: its `echo`, and a frame with a body of `length` bytes. `takeBack` always
   * follows.
   */
  writeAfter(echo: PyBytes, length: number, data: PyBytes, patience: number): void {
    this.next = { echo: echo.toJs(), length, bytes: data.toJs(), patience };
    this.goOn();
  }

  /** When the data of `writeAfter` were written; 0: they were not, and will not be. */
  takeBack(): number {
    const at = this.wroteNext;
    this.next = undefined;
    this.wroteNext = 0;
    if (this.behind.length) this.arrivedAt = this.behindAt;
    this.chunks.push(...this.behind.splice(0));
    return at;
  }

  /** Hold the wire low, or let it go; whether the adapter can. */
  pullLow(low: boolean): Pending<boolean> {
    const did = within(PATIENCE.signals, this.port.setSignals({ break: low }));
    return {
      promise: did.then(
        () => true,
        () => false,
      ),
    };
  }

  close(): void {
    this.chunks.length = this.behind.length = 0;
    this.lose(CLOSED);
  }

  private goOn(): void {
    const { next } = this;
    if (!next || this.wroteNext || this.lost || !this.heard.isAnswer(next.echo, next.length)) return;
    this.wroteNext = now();
    this.heard.begin([]);
    void this.put(next.bytes, next.patience);
  }

  /** Kept when the browser has accepted the bytes, or the port is gone. */
  private put(bytes: Uint8Array, patience: number): Promise<void> {
    return new Promise<void>((resolve) => {
      if (this.lost || !this.writer) return resolve();
      const timer = setTimeout(() => this.lose(STUCK), patience * 1000);
      this.written = () => {
        clearTimeout(timer);
        resolve();
      };
      this.writer.write(bytes).then(this.written, (error) => this.lose(reasonOf(error)));
    });
  }

  private until(time: number, isOver: () => boolean): Pending<void> {
    const promise = new Promise<void>((resolve) => {
      let timer: ReturnType<typeof setTimeout> | undefined;
      const look = () => {
        if (this.wake !== look) return;
        this.lookedAt = now();
        if (!isOver() && now() < time) {
          clearTimeout(timer);
          timer = setTimeout(lookAfterOthers, Math.min((time - now()) * 1000, LONGEST));
          return;
        }
        clearTimeout(timer);
        this.wake = () => undefined;
        resolve();
      };
      // Others first: while Python computed, bytes may have come that nobody has looked at. And a timer that is set in the turn of a timer waits
      // for 4 ms at least.
      const lookAfterOthers = () => afterOthers(look);
      this.wake = look;
      lookAfterOthers();
    });
    return { promise };
  }

  private get hasNews(): boolean {
    return this.chunks.length > 0 || this.lost !== "";
  }

  /** Read until the port is gone. A break, a framing error or an overrun ends the stream, not the port, which has a new one then. */
  private async listen(): Promise<void> {
    let reason = UNPLUGGED;
    for (let stream = this.port.readable; stream && !this.lost; stream = this.port.readable) {
      this.reader = stream.getReader();
      try {
        for (let read = await this.reader.read(); !read.done; read = await this.reader.read()) {
          this.came(read.value);
        }
        break;
      } catch (error) {
        reason = reasonOf(error);
      } finally {
        this.reader.releaseLock();
      }
    }
    this.lose(reason);
  }

  private came(chunk: Uint8Array): void {
    this.heard.add(chunk);
    if (this.wroteNext) {
      this.behind.push(chunk);
      this.behindAt = now();
      return;
    }
    this.arrivedAt = now();
    this.chunks.push(chunk);
    this.goOn();
    this.wake();
  }

  /** The port is gone; called by whoever sees it first. */
  lose(why: string): void {
    if (this.lost) return;
    this.lost = why;
    this.closes(this.closed());
    this.wake();
    this.written();
  }

  /** Closed at once: the page may open the adapter again as soon as it is plugged in, and other programs wait for it. */
  private async closed(): Promise<void> {
    this.reader?.releaseLock();
    this.writer?.releaseLock();
    await this.port.close().catch(() => undefined);
  }
}

async function closedAfter(opened: Promise<void>, port: SerialPort): Promise<void> {
  await opened.then(
    () => port.close(),
    () => undefined,
  );
}

const errorOf = (error: unknown): Error => (error instanceof Error ? error : new Error(String(error)));

const reasonOf = (error: unknown): string => {
  const { name, message } = errorOf(error);
  if (name === STALLS) return STALLED;
  return name === "NetworkError" ? UNPLUGGED : message || name;
};

function joined(chunks: Uint8Array[]): Uint8Array {
  const whole = new Uint8Array(chunks.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const chunk of chunks) {
    whole.set(chunk, at);
    at += chunk.length;
  }
  return whole;
}
