// Prolific: PL2303 of types H (01), HX, HXD, TA, TB, and HXN (G: GC, GB, GT, GL, GE, GS, GR).
//
// The type is known by the descriptor, and where two share a version, by a request that HXN refuses. Errors of the wire come from the interrupt
// endpoint. All but HXN have some rates by name, and others by a divisor; a rate that they have neither way becomes 9600.
import { bcdDevice, fourBytes, lineCoding, unsupported, worst, type Chip, type Line, type LineError, type Packet } from "./chip";
import { Requests } from "./requests";
import type { UsbDevice } from "../webUsb";

const GET_DESCRIPTOR = 0x06;
const DEVICE_DESCRIPTOR = 0x0100;
const SET_LINE = 0x20;
const SET_CONTROL = 0x22;
const SET_BREAK = 0x23;
const HX_STATUS = 0x8080;

/** Requests to read and write a register. */
const OLD = { read: 0x01, write: 0x01 };
const NEW = { read: 0x81, write: 0x80 };

/** Of a packet of the interrupt endpoint. */
const STATE = 8;
const BROKEN = 0x04;
const FRAMING = 0x10;
const PARITY = 0x20;
const OVERRUN = 0x40;

export type Type = "H" | "HX" | "HXD" | "TA" | "TB" | "HXN";

const FASTEST: Record<Type, number> = { H: 1_228_800, HX: 6_000_000, HXD: 12_000_000, TA: 6_000_000, TB: 12_000_000, HXN: 12_000_000 };
const BY_NAME = new Set([
  75, 150, 300, 600, 1200, 1800, 2400, 3600, 4800, 7200, 9600, 14400, 19200, 28800, 38400, 57600, 115200, 230400, 460800, 614400, 921600,
  1228800, 2457600, 3000000, 6000000,
]);
const CLOCK = 12_000_000 * 32;
const HXN_VERSIONS = new Set([0x0100, 0x0105, 0x0300, 0x0305, 0x0400, 0x0405, 0x0500, 0x0505, 0x0600, 0x0605, 0x0700, 0x0705]);

/** The four bytes that ask for a baud rate, and the rate that they give: clock / (mantissa·4^exponent), of TA and TB clock / (mantissa·2^exponent). */
export function encodedRate(type: Type, baud: number): { bytes: Uint8Array; rate: number } {
  if (baud < 1 || baud > FASTEST[type]) throw unsupported(`This PL2303 chip has no ${baud} bit/s.`);
  if (type === "HXN" || BY_NAME.has(baud)) return { bytes: fourBytes(baud), rate: baud };
  const fine = type === "TA" || type === "TB";
  const [step, most, highest] = fine ? [1, 2047, 15] : [2, 511, 7];
  let mantissa = Math.max(1, Math.floor(CLOCK / baud));
  let exponent = 0;
  while (mantissa > most && exponent < highest) {
    mantissa >>= step;
    exponent += 1;
  }
  if (mantissa > most) throw unsupported(`This PL2303 chip has no ${baud} bit/s.`);
  const high = fine ? ((exponent & ~1) << 4) | (mantissa >> 8) : (exponent << 1) | (mantissa >> 8);
  return { bytes: new Uint8Array([mantissa & 0xff, high, fine ? exponent & 1 : 0, 0x80]), rate: CLOCK / mantissa / 2 ** (step * exponent) };
}

export class Pl2303 implements Chip {
  granularity = 0.001;
  private readonly vendor: Requests;
  private readonly line: Requests;
  private registers = OLD;

  /** `clearHalts`: reset both bulk endpoints. */
  constructor(
    private readonly device: UsbDevice,
    private readonly clearHalts: () => Promise<void>,
  ) {
    this.vendor = new Requests(device, "vendor", "device");
    this.line = new Requests(device, "class", "interface");
  }

  async start(line: Line): Promise<number> {
    const type = await this.type();
    const { bytes, rate } = encodedRate(type, line.baudRate);
    this.registers = type === "HXN" ? NEW : OLD;
    if (type !== "HXN") await this.wake(type === "H" ? 0x24 : 0x44);
    if (type === "H") await this.clearHalts();
    else if (type === "HXN") await this.write(0x07, 0x03);
    else {
      await this.write(0x08, 0);
      await this.write(0x09, 0);
    }
    await this.line.send(SET_LINE, 0, 0, lineCoding(bytes, line));
    // No flow control.
    if (type === "HXN") await this.update(0x0a, 0x0a, 0x1c, 0x1c);
    else await this.update(0x80, 0x00, 0xf0, 0);
    return rate;
  }

  setSignals(dtr: boolean, rts: boolean): Promise<void> {
    return this.line.send(SET_CONTROL, (dtr ? 1 : 0) | (rts ? 2 : 0), 0);
  }

  setBreak(low: boolean): Promise<void> {
    return this.line.send(SET_BREAK, low ? 0xffff : 0, 0);
  }

  unpack(bytes: Uint8Array): Packet {
    return { bytes, error: null };
  }

  readNotice(packet: Uint8Array): LineError | null {
    const state = packet[STATE] ?? 0;
    return worst((state & BROKEN) > 0, (state & PARITY) > 0, (state & FRAMING) > 0, (state & OVERRUN) > 0);
  }

  /** The start that the types before HXN need. Its answers mean nothing, and copies refuse some of it. */
  private async wake(last: number): Promise<void> {
    const write = (register: number, value: number) => this.vendor.sendMaybe(OLD.write, register, value);
    await this.read(0x8484);
    await write(0x0404, 0);
    await this.read(0x8484);
    await this.read(0x8383);
    await this.read(0x8484);
    await write(0x0404, 1);
    await this.read(0x8484);
    await this.read(0x8383);
    await write(0, 1);
    await write(1, 0);
    await write(2, last);
  }

  private async type(): Promise<Type> {
    const descriptor = await this.vendor.of("standard", "device").ask(GET_DESCRIPTOR, DEVICE_DESCRIPTOR, 0, 18);
    const longest = descriptor[7];
    if (this.device.deviceClass === 0x02 || longest !== 64) return "H";
    const version = bcdDevice(this.device);
    if (this.device.usbVersionMajor < 2) return version === 0x0400 ? "HXD" : "HX";
    if (version === 0x0300 && (await this.hasHxStatus())) return "TA";
    if (version === 0x0500 && (await this.hasHxStatus())) return "TB";
    if (HXN_VERSIONS.has(version)) return "HXN";
    throw unsupported(`This PL2303 chip is unknown: bcdDevice ${version.toString(16)}.`);
  }

  private async hasHxStatus(): Promise<boolean> {
    return (await this.vendor.askMaybe(OLD.read, HX_STATUS, 0, 1)) !== null;
  }

  /** The value of a register; 0 where a copy of the chip refuses to be read. */
  private async read(register: number): Promise<number> {
    const answer = await this.vendor.askMaybe(this.registers.read, register, 0, 1);
    return answer?.[0] ?? 0;
  }

  private write(register: number, value: number): Promise<void> {
    return this.vendor.send(this.registers.write, register, value);
  }

  private async update(from: number, to: number, mask: number, bits: number): Promise<void> {
    await this.write(to, ((await this.read(from)) & ~mask) | bits);
  }
}
