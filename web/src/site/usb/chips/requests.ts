// Control requests to a device. Each is waited for in bounded time, and its status is looked at: a promise is kept with a stall, too.
import { within } from "../../within";
import type { UsbDevice, UsbRequest } from "../webUsb";

/** ms for one request; it takes about one. */
const PATIENCE = 1000;

/** The name of the error of a chip that refuses a request: another chip than it says, a bad copy, or one that hangs. */
export const REFUSES = "ChipError";

type Kind = UsbRequest["requestType"];

export class Requests {
  constructor(
    private readonly device: UsbDevice,
    private readonly kind: Kind,
    private readonly recipient: UsbRequest["recipient"],
  ) {}

  /** The requests of another kind to the same device. */
  of(kind: Kind, recipient: UsbRequest["recipient"]): Requests {
    return new Requests(this.device, kind, recipient);
  }

  /** Send a request, with data where there are any. */
  async send(request: number, value: number, index: number, data?: Uint8Array<ArrayBuffer>): Promise<void> {
    if (!(await this.sendMaybe(request, value, index, data))) throw refused(request, value, "stall");
  }

  /** As `send`; false: the chip does not know the request. */
  async sendMaybe(request: number, value: number, index: number, data?: Uint8Array<ArrayBuffer>): Promise<boolean> {
    const { status, bytesWritten } = await within(PATIENCE, this.device.controlTransferOut(this.setup(request, value, index), data));
    if (status === "stall") return false;
    if ((status ?? "ok") !== "ok") throw refused(request, value, status);
    if (data && bytesWritten !== data.length) throw refused(request, value, "short");
    return true;
  }

  /** Ask for so many bytes. */
  async ask(request: number, value: number, index: number, length: number): Promise<Uint8Array> {
    const answer = await this.askMaybe(request, value, index, length);
    if (answer === null) throw refused(request, value, "stall");
    return answer;
  }

  /** As `ask`; null: the chip does not know the request. */
  async askMaybe(request: number, value: number, index: number, length: number): Promise<Uint8Array | null> {
    const { status, data } = await within(PATIENCE, this.device.controlTransferIn(this.setup(request, value, index), length));
    if (status === "stall") return null;
    if ((status ?? "ok") !== "ok") throw refused(request, value, status);
    if (data?.byteLength !== length) throw refused(request, value, "short");
    return new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  }

  private setup(request: number, value: number, index: number): UsbRequest {
    return { requestType: this.kind, recipient: this.recipient, request, value, index };
  }
}

const refused = (request: number, value: number, why = "no status"): DOMException =>
  new DOMException(`The chip refused request ${hex(request)} with value ${hex(value)}: ${why}.`, REFUSES);

const hex = (number: number): string => `0x${number.toString(16)}`;
