// CDC-ACM, a class of devices of any maker: CH342, CH343, CH344, CH9102, MCP2200, MCP2221 and many boards. Errors of the wire come from the
// interrupt endpoint. The device does not say which rate it makes of the one that is asked for.
import { fourBytes, lineCoding, worst, type Chip, type Line, type LineError, type Packet } from "./chip";
import { Requests } from "./requests";
import type { UsbDevice } from "../webUsb";

const SET_LINE_CODING = 0x20;
const SET_CONTROL_LINE_STATE = 0x22;
const SEND_BREAK = 0x23;

/** The head of a notification, and its bits. */
const SERIAL_STATE = [0xa1, 0x20];
const STATE = 8;
const BROKEN = 0x04;
const FRAMING = 0x10;
const PARITY = 0x20;
const OVERRUN = 0x40;

export class CdcAcm implements Chip {
  granularity = 0.001;
  private readonly requests: Requests;

  /** `control`: the number of the interface that takes the requests. */
  constructor(
    device: UsbDevice,
    private readonly control: number,
  ) {
    this.requests = new Requests(device, "class", "interface");
  }

  async start(line: Line): Promise<number> {
    await this.requests.send(SET_LINE_CODING, 0, this.control, lineCoding(fourBytes(line.baudRate), line));
    return line.baudRate;
  }

  setSignals(dtr: boolean, rts: boolean): Promise<void> {
    return this.requests.send(SET_CONTROL_LINE_STATE, (dtr ? 1 : 0) | (rts ? 2 : 0), this.control);
  }

  setBreak(low: boolean): Promise<void> {
    return this.requests.send(SEND_BREAK, low ? 0xffff : 0, this.control);
  }

  unpack(bytes: Uint8Array): Packet {
    return { bytes, error: null };
  }

  readNotice(packet: Uint8Array): LineError | null {
    if (packet[0] !== SERIAL_STATE[0] || packet[1] !== SERIAL_STATE[1]) return null;
    const state = packet[STATE] ?? 0;
    return worst((state & BROKEN) > 0, (state & PARITY) > 0, (state & FRAMING) > 0, (state & OVERRUN) > 0);
  }
}
