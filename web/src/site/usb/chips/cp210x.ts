// Silicon Labs: CP2101 to CP2105, CP2108, CP2102N.
//
// CP2101, CP2102, CP2103, CP2108 and the second port of a CP2105 have only the rates of AN205's table, and take the nearest one above: a CP2102
// makes 14400 bit/s of 10400. The others divide 24 MHz.
import { fourBytes, PARITIES, unsupported, worst, type Chip, type Line, type LineError, type Packet } from "./chip";
import { Requests } from "./requests";
import type { UsbDevice } from "../webUsb";

const ENABLE = 0x00;
const LINE_CONTROL = 0x03;
const BREAK = 0x05;
const MODEM = 0x07;
const STATUS = 0x10;
const PURGE = 0x12;
const FLOW = 0x13;
const BAUD = 0x1e;
const VENDOR = 0xff;
const PART_NUMBER = 0x370b;

/** Of PURGE: all queues; a CP2108 hangs now and then without. */
const ALL_QUEUES = 0x0f;
/** Bytes of the answer to STATUS; the first four are the errors. */
const STATUS_BYTES = 19;
const BROKEN = 0x01;
const FRAMING = 0x02;
const OVERRUN = 0x04 | 0x08;
const PARITY = 0x10;

/** What a part can: its rates, and whether it divides 24 MHz. */
interface Part {
  readonly lowest: number;
  readonly highest: number;
  readonly divides: boolean;
}

const CP2101 = 0x01;
const CP2105 = 0x05;
const PARTS: ReadonlyMap<number, Part> = new Map([
  [CP2101, { lowest: 300, highest: 921_600, divides: false }],
  [0x02, { lowest: 300, highest: 1_000_000, divides: false }],
  [0x03, { lowest: 300, highest: 1_000_000, divides: false }],
  [0x04, { lowest: 300, highest: 2_000_000, divides: true }],
  [CP2105, { lowest: 300, highest: 2_000_000, divides: true }],
  [0x08, { lowest: 300, highest: 2_000_000, divides: false }],
  ...[0x20, 0x21, 0x22].map((it) => [it, { lowest: 300, highest: 3_000_000, divides: true }] as const), // CP2102N
]);
const UNKNOWN: Part = { lowest: 300, highest: 2_000_000, divides: false };
const SECOND_OF_CP2105: Part = { lowest: 2400, highest: 921_600, divides: false };

/** AN205, table 1: a rate, and the highest wish that becomes it. */
const TABLE: readonly (readonly [rate: number, upTo: number])[] = [
  [300, 300],
  [600, 600],
  [1200, 1200],
  [1800, 1800],
  [2400, 2400],
  [4000, 4000],
  [4800, 4803],
  [7200, 7207],
  [9600, 9612],
  [14400, 14428],
  [16000, 16062],
  [19200, 19250],
  [28800, 28912],
  [38400, 38601],
  [51200, 51558],
  [56000, 56280],
  [57600, 58053],
  [64000, 64111],
  [76800, 77608],
  [115200, 117028],
  [128000, 129347],
  [153600, 156868],
  [230400, 237832],
  [250000, 254234],
  [256000, 273066],
  [460800, 491520],
  [500000, 567138],
  [576000, 670254],
  [921600, Infinity],
];
/** A CP2101 does not have these. */
const NOT_2101 = new Set([4000, 16000, 51200, 64000, 76800, 153600, 250000, 256000, 500000, 576000]);

/** The rate that a part makes of a baud rate. `port`: 0 is the first. */
export function rateOf(partNumber: number, port: number, baud: number): number {
  const part = partNumber === CP2105 && port > 0 ? SECOND_OF_CP2105 : (PARTS.get(partNumber) ?? UNKNOWN);
  if (baud < part.lowest || baud > part.highest) throw unsupported(`This CP210x chip has no ${baud} bit/s.`);
  if (part.divides) {
    const clock = baud <= 365 ? 6_000_000 : 24_000_000;
    return clock / Math.round(clock / baud);
  }
  if (baud >= 1_000_000) return baud;
  const rates = partNumber === CP2101 ? TABLE.filter(([rate]) => !NOT_2101.has(rate)) : TABLE;
  return rates.find(([, upTo]) => baud <= upTo)![0];
}

export class Cp210x implements Chip {
  granularity = 0.001;
  private readonly requests: Requests;
  /** The errors of the last answer: a chip may keep them. */
  private errors = 0;

  constructor(
    device: UsbDevice,
    private readonly port: number,
  ) {
    this.requests = new Requests(device, "vendor", "interface");
  }

  async start(line: Line): Promise<number> {
    const part = await this.requests.of("vendor", "device").askMaybe(VENDOR, PART_NUMBER, this.port, 1);
    const rate = rateOf(part?.[0] ?? 0, this.port, line.baudRate);
    await this.send(ENABLE, 0);
    await this.send(ENABLE, 1);
    await this.send(BAUD, 0, fourBytes(Math.floor(rate)));
    const stopBits = line.stopBits === 2 ? 2 : 0;
    await this.send(LINE_CONTROL, (line.dataBits << 8) | (PARITIES.indexOf(line.parity) << 4) | stopBits);
    await this.send(FLOW, 0, new Uint8Array(16));
    return rate;
  }

  async setSignals(dtr: boolean, rts: boolean): Promise<void> {
    await this.send(MODEM, 0x0300 | (dtr ? 1 : 0) | (rts ? 2 : 0));
  }

  setBreak(low: boolean): Promise<void> {
    return this.send(BREAK, low ? 1 : 0);
  }

  unpack(bytes: Uint8Array): Packet {
    return { bytes, error: null };
  }

  /** Copies exist that mark errors among the bytes in another way, or not at all; this question harms no byte. */
  async askError(): Promise<LineError | null> {
    const answer = await this.requests.askMaybe(STATUS, 0, this.port, STATUS_BYTES);
    const errors = answer?.[0] ?? 0;
    const fresh = errors & ~this.errors;
    this.errors = errors;
    return worst((fresh & BROKEN) > 0, (fresh & PARITY) > 0, (fresh & FRAMING) > 0, (fresh & OVERRUN) > 0);
  }

  async stop(): Promise<void> {
    await this.send(PURGE, ALL_QUEUES);
    await this.send(ENABLE, 0);
  }

  private send(request: number, value: number, data?: Uint8Array<ArrayBuffer>): Promise<void> {
    return this.requests.send(request, value, this.port, data);
  }
}
