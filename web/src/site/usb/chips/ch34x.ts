// WCH: CH340, CH341, CH330. (CH342, CH343, CH344, CH9102 are CDC-ACM devices.)
//
// The chip waits for a full packet of 32 bytes unless a bit of the prescaler forbids it. Some chips and copies have neither a break nor all
// prescalers: they stall when the break's register is read. A break is then a zero at the lowest rate, which takes 0.2 s however long it
// should be. The chips report no errors of the wire.
import { unsupported, type Chip, type Line, type Packet } from "./chip";
import { Requests } from "./requests";
import type { UsbDevice } from "../webUsb";

const READ_VERSION = 0x5f;
const READ_REGISTERS = 0x95;
const WRITE_REGISTERS = 0x9a;
const BEGIN = 0xa1;
const MODEM = 0xa4;

/** Two registers of one request, the second one in the high byte. */
const PRESCALER_AND_DIVISOR = 0x1312;
const LINE_CONTROL = 0x2518;
const BREAK_AND_LINE_CONTROL = 0x1805;
const BREAK = 0x05;

const DTR = 0x20;
const RTS = 0x40;
/** Of the prescaler: hand bytes over at once. */
const AT_ONCE = 0x80;
const NO_BREAK = 0x01;
const RECEIVES = 0x80;
const SENDS = 0x40;
const TWO_STOP_BITS = 0x04;
const PARITY = { none: 0, odd: 0x08, even: 0x18, mark: 0x28, space: 0x38 };

/** From this version on there is the bit `AT_ONCE`; in an older one it means the opposite. */
const WAITS = 0x28;
/** From this version on there is the register of the line. */
const HAS_LINE_CONTROL = 0x30;

const CLOCK = 48_000_000;
const SLOWEST = 46;
const FASTEST = 3_000_000;
const EIGHT_N_ONE = RECEIVES | SENDS | 3;

/**
 * The prescaler and the divisor of a baud rate, as the registers have them, and the rate that they give: 48 MHz / (2^(12 - 3·ps - fact)·div).
 * `limited`: the chip has fact = 1 only with ps = 3.
 */
export function divisor(baud: number, limited = false): { code: number; rate: number } {
  if (baud < SLOWEST || baud > FASTEST) throw unsupported(`This CH34x chip has no ${baud} bit/s.`);
  // The highest clock whose divisor is less than 512.
  let ps = 3;
  while (ps > 0 && baud <= Math.floor(CLOCK / (512 << (11 - 3 * ps)))) ps -= 1;
  let fact = 1;
  let clock = CLOCK / (1 << (11 - 3 * ps));
  let div = Math.floor(clock / baud);
  if (div < 9 || div > 255 || (limited && ps < 3)) {
    fact = 0;
    clock /= 2;
    div = Math.floor(div / 2);
  }
  if (clock / div - baud >= baud - clock / (div + 1)) div += 1;
  // The receiver bears more with the lower clock.
  if (fact === 1 && div % 2 === 0) {
    fact = 0;
    clock /= 2;
    div /= 2;
  }
  return { code: ((256 - div) << 8) | (fact << 2) | ps, rate: clock / div };
}

export class Ch34x implements Chip {
  granularity = 0.001;
  private readonly requests: Requests;
  private version = 0;
  private limited = false;
  private line = 0;
  private speed = 0;
  private breakEnds = 0;

  /** `write`: send bytes to the wire, for a break of a chip that has none. */
  constructor(
    device: UsbDevice,
    private readonly write: (bytes: Uint8Array<ArrayBuffer>) => Promise<void>,
  ) {
    this.requests = new Requests(device, "vendor", "device");
  }

  async start({ baudRate, dataBits, parity, stopBits }: Line): Promise<number> {
    const [version] = await this.requests.ask(READ_VERSION, 0, 0, 2);
    this.version = version!;
    this.line = RECEIVES | SENDS | (dataBits - 5) | PARITY[parity] | (stopBits === 2 ? TWO_STOP_BITS : 0);
    if (this.version < HAS_LINE_CONTROL && this.line !== EIGHT_N_ONE) throw unsupported("This old CH34x chip has only 8N1.");
    await this.requests.send(BEGIN, 0, 0);
    this.limited = (await this.requests.askMaybe(READ_REGISTERS, BREAK, 0, 2)) === null;
    const { code, rate } = divisor(baudRate, this.limited);
    this.speed = code;
    await this.setLine(this.speed, this.line);
    return rate;
  }

  setSignals(dtr: boolean, rts: boolean): Promise<void> {
    const held = (dtr ? DTR : 0) | (rts ? RTS : 0);
    return this.requests.send(MODEM, ~held & 0xffff, 0);
  }

  async setBreak(low: boolean): Promise<void> {
    if (this.limited) return this.simulateBreak(low);
    const [registers, lineControl] = await this.requests.ask(READ_REGISTERS, BREAK_AND_LINE_CONTROL, 0, 2);
    const first = low ? registers! & ~NO_BREAK : registers! | NO_BREAK;
    const second = low ? lineControl! & ~SENDS : lineControl! | SENDS;
    await this.requests.send(WRITE_REGISTERS, BREAK_AND_LINE_CONTROL, (second << 8) | first);
  }

  unpack(bytes: Uint8Array): Packet {
    return { bytes, error: null };
  }

  private async setLine(speed: number, line: number): Promise<void> {
    await this.requests.send(WRITE_REGISTERS, PRESCALER_AND_DIVISOR, this.version < WAITS ? speed : speed | AT_ONCE);
    if (this.version >= HAS_LINE_CONTROL) await this.requests.send(WRITE_REGISTERS, LINE_CONTROL, line);
  }

  private async simulateBreak(low: boolean): Promise<void> {
    if (low) {
      await this.setLine(divisor(SLOWEST, true).code, EIGHT_N_ONE);
      await this.write(new Uint8Array(1));
      this.breakEnds = performance.now() + (11 / SLOWEST) * 1000; // start, eight bits, stop, one more
      return;
    }
    const left = this.breakEnds - performance.now();
    if (left > 0) await new Promise((over) => setTimeout(over, left));
    await this.setLine(this.speed, this.line);
  }
}
