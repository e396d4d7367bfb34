// FTDI: FT8U232AM, FT232BM, FT2232C, FT232R, FT-X and the fast ones (FT232H, FT2232H, FT4232H, HP).
//
// Each packet begins with two bytes of status, also within a longer transfer. While its latency timer runs, the chip waits for a full packet. An
// event character ends that wait at once: it is the last byte of a message, so an answer comes as soon as it is whole, from an AM, too. Within a
// message the timer may then run its usual 16 ms: at 1 ms each byte of the wire is a transfer, and a silent wire 1000 a second, which take the
// browser and this worker as much time as the program takes. A chip that knows no event character has the timer at 1 ms.
import { bcdDevice, PARITIES, unsupported, worst, type Chip, type Line, type Packet } from "./chip";
import { Requests } from "./requests";
import type { UsbDevice } from "../webUsb";

const RESET = 0x00;
const MODEM = 0x01;
const FLOW = 0x02;
const BAUD = 0x03;
const DATA = 0x04;
const EVENT = 0x06;
const SET_LATENCY = 0x09;
const GET_LATENCY = 0x0a;

const BREAK = 0x4000;
/** The last byte of a message (§2). */
const END = 0x0d;
/** The event character is on, and is that byte. */
const AT_END = 0x0100 | END;
/** ms; the timer's own setting, and the only one of an AM. */
const LATENCY = 16;
/** ms: the least that the timer can be set to. */
const LEAST_LATENCY = 1;
/** Messages in a row whose packet goes on behind the event character, until the chip counts as one that ignores it. One may: the browser is late. */
const MOST_IGNORED = 3;

/** Bytes of status at the head of a packet, and the bits of the second one. */
const HEAD = 2;
const OVERRUN = 0x02;
const PARITY = 0x04;
const FRAMING = 0x08;
const BROKEN = 0x10;

/** A kind of chip. `coarse`: only some eighths in the divisor; `fast`: a clock of 120 MHz; `names`: requests name the port, from 1. */
export interface Kind {
  readonly coarse?: true;
  readonly fast?: true;
  readonly names?: true;
}

const AM: Kind = { coarse: true };
const PLAIN: Kind = {};
/** By bcdDevice. */
const KINDS: ReadonlyMap<number, Kind> = new Map<number, Kind>([
  [0x0200, AM],
  [0x0400, PLAIN], // BM
  [0x0500, { names: true }], // 2232C
  [0x0600, PLAIN], // R
  [0x1000, { names: true }], // X
  ...[0x0700, 0x0800, 0x0900, 0x2800, 0x2900, 0x3000, 0x3100, 0x3200, 0x3300, 0x3600].map(
    (it) => [it, { fast: true, names: true }] as const,
  ),
]);

/** The codes of 0/8 to 7/8 in a divisor. */
const EIGHTHS = [0, 3, 2, 4, 1, 5, 6, 7];

/** The divisor of a baud rate, 18 bits, and the rate that it gives. */
export function divisor(kind: Kind, baud: number): { code: number; rate: number } {
  const fast = kind.fast === true && baud >= 1200;
  if (baud < 183 || baud > (kind.fast ? 12_000_000 : 3_000_000)) throw unsupported(`This FTDI chip has no ${baud} bit/s.`);
  const clock = fast ? 96_000_000 : 24_000_000; // eighths of a second's bits
  let eighths = Math.min(Math.round(clock / baud), 0x1ffff);
  if (kind.coarse) eighths = coarse(eighths);
  let code = (eighths >> 3) | (EIGHTHS[eighths & 7]! << 14);
  if (eighths === 8) code = 0;
  else if (eighths === 12 && !kind.coarse) code = 1;
  else if (eighths < 16) throw unsupported(`This FTDI chip has no ${baud} bit/s.`);
  return { code: fast ? code | 0x20000 : code, rate: clock / eighths };
}

/** An AM has 0, 1/8, 1/4 and 1/2. */
function coarse(eighths: number): number {
  const whole = eighths & ~7;
  switch (eighths & 7) {
    case 0:
    case 1:
      return eighths;
    case 2:
    case 3:
      return whole + 2;
    case 7:
      return whole + 8;
    default:
      return whole + 4;
  }
}

export class Ftdi implements Chip {
  granularity = LATENCY / 1000;
  private readonly requests: Requests;
  private kind: Kind = PLAIN;
  private channel = 0;
  private format = 0;
  private ignored = 0;

  constructor(
    private readonly device: UsbDevice,
    private readonly port: number,
    private readonly packetSize: number,
  ) {
    this.requests = new Requests(device, "vendor", "device");
  }

  async start(line: Line): Promise<number> {
    this.kind = await this.found();
    this.channel = this.kind.names ? this.port + 1 : 0;
    if (line.dataBits < 7) throw unsupported(`FTDI chips have no ${line.dataBits} data bits.`);
    const { code, rate } = divisor(this.kind, line.baudRate);
    const high = code >> 16;
    await this.send(RESET, 0);
    await this.requests.send(BAUD, code & 0xffff, this.channel ? (high << 8) | this.channel : high);
    this.format = line.dataBits | (PARITIES.indexOf(line.parity) << 8) | ((line.stopBits === 2 ? 2 : 0) << 11);
    await this.send(DATA, this.format);
    await this.send(FLOW, 0);
    const isFlushed = await this.requests.sendMaybe(EVENT, AT_END, this.channel); // a copy of the chip may lack it
    const isSet = this.kind !== AM && (await this.setLatency(isFlushed ? LATENCY : LEAST_LATENCY));
    this.granularity = (isSet && !isFlushed ? LEAST_LATENCY : LATENCY) / 1000;
    this.ignored = 0;
    return rate;
  }

  async setSignals(dtr: boolean, rts: boolean): Promise<void> {
    await this.send(MODEM, dtr ? 0x0101 : 0x0100);
    await this.send(MODEM, rts ? 0x0202 : 0x0200);
  }

  setBreak(low: boolean): Promise<void> {
    return this.send(DATA, this.format | (low ? BREAK : 0));
  }

  /** A packet without bytes repeats the status of the one before: it reports nothing. */
  unpack(transfer: Uint8Array): Packet {
    if (transfer.length <= this.packetSize) return this.unpackOne(transfer);
    const parts: Packet[] = [];
    for (let at = 0; at < transfer.length; at += this.packetSize) parts.push(this.unpackOne(transfer.subarray(at, at + this.packetSize)));
    const bytes = new Uint8Array(parts.flatMap((part) => [...part.bytes]));
    return { bytes, error: parts.find((part) => part.error)?.error ?? null };
  }

  private unpackOne(packet: Uint8Array): Packet {
    const bytes = packet.subarray(HEAD);
    const status = bytes.length ? packet[1]! : 0;
    this.watch(packet);
    return { bytes, error: worst((status & BROKEN) > 0, (status & PARITY) > 0, (status & FRAMING) > 0, (status & OVERRUN) > 0) };
  }

  /** Lower the timer of a copy that has taken the event character, and waits behind it nevertheless. */
  private watch(packet: Uint8Array): void {
    const at = packet.indexOf(END, HEAD);
    if (at < 0 || packet.length === this.packetSize || this.ignored >= MOST_IGNORED) return;
    this.ignored = at === packet.length - 1 ? 0 : this.ignored + 1;
    if (this.ignored === MOST_IGNORED && this.kind !== AM) void this.setLatency(LEAST_LATENCY).catch(() => undefined);
  }

  private setLatency(milliseconds: number): Promise<boolean> {
    return this.requests.sendMaybe(SET_LATENCY, milliseconds, this.channel);
  }

  private send(request: number, value: number): Promise<void> {
    return this.requests.send(request, value, this.channel);
  }

  private async found(): Promise<Kind> {
    const version = bcdDevice(this.device);
    const kind = KINDS.get(version);
    if (!kind) throw unsupported(`This FTDI chip is unknown: bcdDevice ${version.toString(16)}.`);
    // A BM without a serial number says that it is an AM, which has no timer.
    if (kind === AM && !this.device.serialNumber && (await this.requests.askMaybe(GET_LATENCY, 0, 0, 1)) !== null) return PLAIN;
    return kind;
  }
}
