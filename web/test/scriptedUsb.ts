// A USB device as WebUSB has it, for the drivers of serial chips: it notes what is asked of it, answers by a script, and fails as a browser does.
import type { UsbConfiguration, UsbDevice, UsbEndpoint, UsbInResult, UsbOutResult, UsbRequest } from "../src/site/usb/webUsb";

type Answer = readonly number[] | "stall" | "babble" | "hang";

interface Waiting {
  keep(result: UsbInResult): void;
  fail(error: DOMException): void;
}

const bulk = (endpointNumber: number, direction: "in" | "out", packetSize: number): UsbEndpoint => ({
  endpointNumber,
  direction,
  type: "bulk",
  packetSize,
});
const interrupt = (endpointNumber: number, packetSize: number): UsbEndpoint => ({
  endpointNumber,
  direction: "in",
  type: "interrupt",
  packetSize,
});

/** A configuration of vendor-specific interfaces, one for each list of endpoints. */
const vendor = (...interfaces: UsbEndpoint[][]): UsbConfiguration => ({
  configurationValue: 1,
  interfaces: interfaces.map((endpoints, interfaceNumber) => ({
    interfaceNumber,
    alternate: { interfaceClass: 0xff, interfaceSubclass: 0, endpoints },
  })),
});

export class ScriptedUsb implements UsbDevice {
  usbVersionMajor = 2;
  usbVersionMinor = 0;
  deviceVersionMajor = 0;
  deviceVersionMinor = 0;
  deviceVersionSubminor = 0;
  deviceClass = 0;
  serialNumber: string | null = "A1";
  opened = false;
  configuration: UsbConfiguration | null = null;
  /** Control requests: direction, type and recipient as their byte, request, value, index, and data; all hexadecimal. */
  asked: string[] = [];
  /** What is answered, by the beginning of a request in `asked`; the last one that fits counts. Otherwise: yes. */
  answers: [request: string, answer: Answer][] = [];
  written: number[][] = [];
  claimed: number[] = [];
  halted: string[] = [];
  /** Bytes that a transfer to the wire takes at most. */
  takes = Infinity;
  /** What a transfer to the wire is answered. */
  writes: "ok" | "stall" | "hang" = "ok";
  refusesClaim = false;
  refusesOpen: DOMException | null = null;
  hangs: "open" | "close" | null = null;
  private pulled = false;
  private readonly waiting = new Map<number, Waiting[]>();
  private readonly packets = new Map<number, UsbInResult[]>();

  constructor(
    readonly vendorId: number,
    readonly productId: number,
    readonly configurations: readonly UsbConfiguration[],
    version: number,
  ) {
    this.deviceVersionMajor = version >> 8;
    this.deviceVersionMinor = (version >> 4) & 15;
    this.deviceVersionSubminor = version & 15;
  }

  async open(): Promise<void> {
    if (this.hangs === "open") return never();
    this.mustBeThere();
    if (this.refusesOpen) throw this.refusesOpen;
    this.opened = true;
  }

  async close(): Promise<void> {
    if (this.hangs === "close") return never();
    this.mustBeThere();
    this.opened = false;
    this.claimed = [];
    this.abort();
  }

  async selectConfiguration(value: number): Promise<void> {
    this.mustBeThere();
    this.configuration = this.configurations.find((it) => it.configurationValue === value) ?? null;
  }

  async claimInterface(number: number): Promise<void> {
    this.mustBeThere();
    if (this.refusesClaim) throw new DOMException("Unable to claim interface.", "NetworkError");
    this.claimed.push(number);
  }

  async controlTransferIn(setup: UsbRequest, length: number): Promise<UsbInResult> {
    const answer = this.answer(0x80, setup, "");
    if (answer === "hang") return never();
    if (typeof answer === "string") return { status: answer };
    return { status: "ok", data: view(Uint8Array.from({ length: answer ? answer.length : length }, (_, at) => answer?.[at] ?? 0)) };
  }

  async controlTransferOut(setup: UsbRequest, data?: BufferSource): Promise<UsbOutResult> {
    const bytes = data ? [...bytesOf(data)] : [];
    const answer = this.answer(0, setup, bytes.map((byte) => ` ${hex(byte, 2)}`).join(""));
    if (answer === "hang") return never();
    return typeof answer === "string" ? { status: answer, bytesWritten: 0 } : { status: "ok", bytesWritten: bytes.length };
  }

  transferIn(endpoint: number, length: number): Promise<UsbInResult> {
    return new Promise((keep, fail) => {
      if (this.pulled) return fail(new DOMException("The device was disconnected.", "NotFoundError"));
      if (!this.opened || !this.claimed.length) return fail(new DOMException("The device must be opened first.", "InvalidStateError"));
      const size = this.endpoint(endpoint, "in").packetSize;
      if (length !== size) return fail(new DOMException(`${length} bytes asked of packets of ${size}`, "TestError"));
      const ready = this.packets.get(endpoint)?.shift();
      if (ready) return keep(ready);
      this.waiting.set(endpoint, [...(this.waiting.get(endpoint) ?? []), { keep, fail }]);
    });
  }

  async transferOut(endpoint: number, data: BufferSource): Promise<UsbOutResult> {
    this.mustBeThere();
    this.endpoint(endpoint, "out");
    if (this.writes === "hang") return never();
    if (this.writes === "stall") return { status: "stall", bytesWritten: 0 };
    const bytes = [...bytesOf(data)].slice(0, this.takes);
    this.written.push(bytes);
    return { status: "ok", bytesWritten: bytes.length };
  }

  async clearHalt(direction: "in" | "out", endpoint: number): Promise<void> {
    this.mustBeThere();
    this.halted.push(`${direction} ${endpoint}`);
  }

  /** Transfers that wait for a packet of the endpoint. */
  ahead(endpoint = this.input): number {
    return this.waiting.get(endpoint)?.length ?? 0;
  }

  /** The chip has a packet. */
  send(packet: readonly number[], endpoint = this.input): void {
    this.result({ status: "ok", data: view(Uint8Array.from(packet)) }, endpoint);
  }

  /** The next transfer, or all that wait, end so. */
  spoil(status: "stall" | "babble", count = status === "stall" ? this.ahead() : 1): void {
    for (let i = 0; i < count; i++) this.result({ status }, this.input);
  }

  /** The plug is pulled out. */
  pull(): void {
    this.pulled = true;
    this.opened = false;
    this.abort();
  }

  private result(result: UsbInResult, endpoint: number): void {
    const waiting = this.waiting.get(endpoint)?.shift();
    if (waiting) waiting.keep(result);
    else this.packets.set(endpoint, [...(this.packets.get(endpoint) ?? []), result]);
  }

  /** As Chromium: what waits is rejected after what else there is to do. */
  private abort(): void {
    const all = [...this.waiting.values()].flat();
    this.waiting.clear();
    setTimeout(() => all.forEach(({ fail }) => fail(new DOMException("The transfer was cancelled.", "AbortError"))));
  }

  private answer(direction: number, { requestType, recipient, request, value, index }: UsbRequest, data: string): Answer | undefined {
    this.mustBeThere();
    const kind =
      direction | (["standard", "class", "vendor"].indexOf(requestType) << 5) | ["device", "interface", "endpoint"].indexOf(recipient);
    const it = `${hex(kind, 2)} ${hex(request, 2)} ${hex(value, 4)} ${hex(index, 4)}`;
    this.asked.push(it + data);
    return this.answers.findLast(([begin]) => it.startsWith(begin))?.[1];
  }

  private get input(): number {
    return this.configurations[0]!.interfaces.flatMap((it) => it.alternate.endpoints).find(
      (it) => it.type === "bulk" && it.direction === "in",
    )!.endpointNumber;
  }

  private endpoint(number: number, direction: "in" | "out"): UsbEndpoint {
    const all = this.configurations[0]!.interfaces.flatMap((it) => it.alternate.endpoints);
    const found = all.find((it) => it.endpointNumber === number && it.direction === direction);
    if (!found) throw new DOMException("no such endpoint", "NotFoundError");
    return found;
  }

  private mustBeThere(): void {
    if (this.pulled) throw new DOMException("The device was disconnected.", "NotFoundError");
  }
}

const never = <T>(): Promise<T> => new Promise(() => undefined);
const hex = (number: number, digits: number): string => number.toString(16).padStart(digits, "0");
const view = (bytes: Uint8Array): DataView => new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
const bytesOf = (data: BufferSource): Uint8Array =>
  data instanceof ArrayBuffer ? new Uint8Array(data) : new Uint8Array(data.buffer, data.byteOffset, data.byteLength);

/** An FTDI chip, by its bcdDevice. */
export const ftdi = (version = 0x0600, packetSize = 64): ScriptedUsb =>
  new ScriptedUsb(0x0403, 0x6001, [vendor([bulk(1, "in", packetSize), bulk(2, "out", packetSize)])], version);

/** A CH340 of a version of its own. */
export function ch340(version = 0x31): ScriptedUsb {
  const it = new ScriptedUsb(0x1a86, 0x7523, [vendor([bulk(2, "in", 32), bulk(2, "out", 32), interrupt(1, 8)])], 0x0264);
  it.answers = [
    ["c0 5f", [version, 0]],
    ["c0 95 1805", [0x01, 0xc3]],
    ["c0 95 0005", [0x01, 0x00]],
  ];
  return it;
}

/** A CP210x, by its part number. */
export function cp210x(part = 0x02): ScriptedUsb {
  const it = new ScriptedUsb(0x10c4, 0xea60, [vendor([bulk(1, "in", 64), bulk(1, "out", 64)])], 0x0100);
  it.answers = [["c0 ff 370b", [part]]];
  return it;
}

/** A PL2303, by its bcdDevice, the USB version and the longest packet of its control endpoint. */
export function pl2303(version = 0x0300, usb = 1, longest = 64): ScriptedUsb {
  const it = new ScriptedUsb(0x067b, 0x2303, [vendor([interrupt(1, 10), bulk(2, "out", 64), bulk(3, "in", 64)])], version);
  it.usbVersionMajor = usb;
  it.answers = [
    ["80 06", [18, 1, 0, usb, 0, 0, 0, longest, 0x7b, 0x06, 0x03, 0x23, version & 0xff, version >> 8, 1, 2, 0, 1]],
    ["c0 01", [0x44]],
  ];
  return it;
}

/** A CDC-ACM device: a control interface, and one of data. */
export function cdcAcm(): ScriptedUsb {
  const interfaces = [
    { interfaceNumber: 0, alternate: { interfaceClass: 2, interfaceSubclass: 2, endpoints: [interrupt(3, 16)] } },
    { interfaceNumber: 1, alternate: { interfaceClass: 10, interfaceSubclass: 0, endpoints: [bulk(2, "out", 64), bulk(2, "in", 64)] } },
  ];
  return new ScriptedUsb(0x1a86, 0x55d3, [{ configurationValue: 1, interfaces }], 0x0445);
}
