// A SerialPort (Web Serial) over a USB device (WebUSB), with a driver of this page for its chip.
//
// Of what the browser may never settle, each is waited for in bounded time. After a pull a device is another object when it is back.
import { within } from "../within";
import type { SerialOptions, SerialPort } from "../worker/webSerial";
import { channelOf, type Channel } from "./channel";
import type { Chip, Line } from "./chips/chip";
import { unsupported } from "./chips/chip";
import { driverOf } from "./identify";
import { Incoming } from "./incoming";
import { Session, STALLS, unplugged } from "./session";
import type { UsbDevice } from "./webUsb";

/** ms. Android asks the user, when a device is opened for the first time. */
const PATIENCE = { open: 60_000, claim: 2000, signals: 2000, close: 2000 };
/** As Web Serial. */
const BUFFER = 255;

/** The name of the error of a device that another driver or program has. */
export const HELD = "ClaimError";

interface Open {
  readonly chip: Chip;
  readonly session: Session;
  readonly incoming: Incoming;
  dtr: boolean;
  rts: boolean;
}

export class UsbSerialPort extends EventTarget implements SerialPort {
  readonly scheme = "webusb";
  /** ms that `open` may take. */
  readonly patience = PATIENCE.open + 10_000;
  connected = true;
  writable: WritableStream<Uint8Array> | null = null;
  /** Bits a second that the chip makes of the baud rate that was asked for. */
  rate = 0;
  /** s by which the chip hands bytes over late. */
  granularity = 0;
  private it: Open | null = null;
  private opening = false;
  private closing: Promise<void> = Promise.resolve();

  constructor(private readonly device: UsbDevice) {
    super();
  }

  get readable(): ReadableStream<Uint8Array> | null {
    return this.it?.incoming.readable ?? null;
  }

  get serialNumber(): string {
    return this.device.serialNumber ?? "";
  }

  getInfo(): { usbVendorId: number; usbProductId: number } {
    return { usbVendorId: this.device.vendorId, usbProductId: this.device.productId };
  }

  /**
   * Raises NetworkError if the device does not open, SecurityError if that is not allowed, ClaimError if another driver or program has it,
   * NotSupportedError for a line or a chip that is unknown here, ChipError if the chip refuses a request.
   */
  async open({ baudRate, dataBits = 8, parity = "none", stopBits = 1, bufferSize = BUFFER }: SerialOptions): Promise<void> {
    if (this.it || this.opening) throw new DOMException("The port is already open.", "InvalidStateError");
    this.opening = true;
    try {
      await this.closing;
      const channel = await this.claimed();
      const write = (bytes: Uint8Array<ArrayBuffer>) => this.write(channel, bytes);
      const chip = driverOf(this.device, channel, write);
      this.rate = await chip.start({ baudRate, dataBits, parity, stopBits } satisfies Line);
      this.granularity = chip.granularity;
      this.begin(channel, chip, bufferSize);
    } catch (error) {
      await this.release();
      throw error;
    } finally {
      this.opening = false;
    }
  }

  async setSignals(signals: { dataTerminalReady?: boolean; requestToSend?: boolean; break?: boolean }): Promise<void> {
    const { it } = this;
    if (!it) throw new DOMException("The port is closed.", "InvalidStateError");
    const { dataTerminalReady: dtr, requestToSend: rts, break: low } = signals;
    if (dtr !== undefined || rts !== undefined) {
      it.dtr = dtr ?? it.dtr;
      it.rts = rts ?? it.rts;
      await within(PATIENCE.signals, it.chip.setSignals(it.dtr, it.rts));
    }
    if (low !== undefined) await within(PATIENCE.signals, it.chip.setBreak(low));
  }

  /** Never rejected: what can't be closed is gone. */
  async close(): Promise<void> {
    const { it } = this;
    if (!it) return;
    this.end(it);
    this.closing = this.stopped(it);
    await this.closing;
  }

  private async stopped({ chip }: Open): Promise<void> {
    await within(PATIENCE.close, chip.stop?.() ?? Promise.resolve()).catch(() => undefined);
    await this.release();
  }

  /** The browser says that the device was pulled. */
  unplug(): void {
    this.connected = false;
    this.it?.session.lose(new DOMException("The device was unplugged.", "NetworkError"));
    this.dispatchEvent(new Event("disconnect"));
  }

  private async claimed(): Promise<Channel> {
    const { device } = this;
    if (device.opened) await this.release(); // an earlier `close` that hung
    await within(PATIENCE.open, device.open());
    const [only] = device.configurations;
    if (!device.configuration && only) await within(PATIENCE.claim, device.selectConfiguration(only.configurationValue));
    const channel = channelOf(device.configuration ?? only);
    if (channel === null) throw unsupported("The device has no serial port.");
    for (const number of channel.interfaces) {
      await within(PATIENCE.claim, device.claimInterface(number)).catch((error: unknown) => {
        // Another name says that the device is gone, or the browser hangs.
        throw error instanceof DOMException && error.name === "NetworkError" ? new DOMException(error.message, HELD) : error;
      });
    }
    return channel;
  }

  private begin(channel: Channel, chip: Chip, bufferSize: number): void {
    const incoming = new Incoming(bufferSize);
    let outgoing: WritableStreamDefaultController;
    const session = new Session(this.device, channel, chip, incoming, (error) => outgoing.error(error));
    this.writable = new WritableStream<Uint8Array>({
      start: (controller) => void (outgoing = controller),
      write: (bytes) => this.write(channel, bytes),
    });
    this.it = { chip, session, incoming, dtr: false, rts: false };
    session.begin();
  }

  private async write({ output }: Channel, bytes: Uint8Array): Promise<void> {
    let rest = bytes.slice();
    try {
      while (rest.length) {
        const { status, bytesWritten } = await this.device.transferOut(output.endpointNumber, rest);
        if (status === "stall") await within(PATIENCE.signals, this.device.clearHalt("out", output.endpointNumber));
        if ((status ?? "ok") !== "ok" || bytesWritten === 0) throw new DOMException(`The chip takes no bytes: ${status ?? "ok"}.`, STALLS);
        rest = rest.subarray(bytesWritten);
      }
    } catch (error) {
      throw error instanceof DOMException && error.name === STALLS ? error : unplugged(error);
    }
  }

  private end(it: Open): void {
    this.it = null;
    this.writable = null;
    it.session.end();
    it.incoming.close();
  }

  private async release(): Promise<void> {
    await within(PATIENCE.close, this.device.close()).catch(() => undefined);
  }
}
