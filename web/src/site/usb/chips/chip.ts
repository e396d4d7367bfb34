// What a driver of a USB serial chip is, whatever the chip. A driver knows requests and packets; transfers, streams and errors of the bus are
// the port's (`../usbSerialPort.ts`).
//
// Requests and formulas are those of Linux' drivers (ftdi_sio, ch341, cp210x, pl2303, cdc-acm). They were tried on models of the chips, which
// Linux' own drivers accept, and never on silicon.

import type { UsbDevice } from "../webUsb";

export type Parity = "none" | "odd" | "even" | "mark" | "space";

/** How a byte stands on the wire. */
export interface Line {
  readonly baudRate: number;
  readonly dataBits: 5 | 6 | 7 | 8;
  readonly parity: Parity;
  readonly stopBits: 1 | 2;
}

/** What a chip says of the wire, by the names of Web Serial. The port goes on after it. */
export type LineError = "BreakError" | "FramingError" | "ParityError" | "BufferOverrunError";

/** What one packet brought. */
export interface Packet {
  readonly bytes: Uint8Array;
  readonly error: LineError | null;
}

/** A chip on an open device whose interfaces are claimed. */
export interface Chip {
  /** s by which it hands bytes over late; known after `start`. */
  readonly granularity: number;
  /** Reset the chip, and set the line; returns the baud rate that the chip makes of it. Raises NotSupportedError for a line that it can't. */
  start(line: Line): Promise<number>;
  setSignals(dtr: boolean, rts: boolean): Promise<void>;
  /** Hold the wire low, or let it go. */
  setBreak(low: boolean): Promise<void>;
  /** The bytes of the wire in a packet of the bulk endpoint. */
  unpack(packet: Uint8Array): Packet;
  /** The error that a packet of the interrupt endpoint reports. Missing: the chip reports none there. */
  readNotice?(packet: Uint8Array): LineError | null;
  /** Ask for an error that is new since the last time. Missing: the chip can't be asked. */
  askError?(): Promise<LineError | null>;
  /** What a chip needs before its device is closed. */
  stop?(): Promise<void>;
}

/** The order of parities in the registers of FTDI, CP210x, PL2303 and CDC. */
export const PARITIES: readonly Parity[] = ["none", "odd", "even", "mark", "space"];

/** The line of CDC's line coding, which PL2303 has as well: rate, stop bits, parity, data bits. */
export function lineCoding(rate: Uint8Array, { stopBits, parity, dataBits }: Line): Uint8Array<ArrayBuffer> {
  return new Uint8Array([...rate, stopBits === 2 ? 2 : 0, PARITIES.indexOf(parity), dataBits]);
}

/** A number of 32 bits as it goes over the bus. */
export const fourBytes = (number: number): Uint8Array<ArrayBuffer> => {
  const bytes = new Uint8Array(4);
  new DataView(bytes.buffer).setUint32(0, number, true);
  return bytes;
};

/** The error that counts of several: a break is a framing error as well. */
export function worst(breaks: boolean, parity: boolean, framing: boolean, overrun: boolean): LineError | null {
  if (breaks) return "BreakError";
  if (parity) return "ParityError";
  if (framing) return "FramingError";
  return overrun ? "BufferOverrunError" : null;
}

/** The error of a line or a chip that can't be used. */
export const unsupported = (message: string): DOMException => new DOMException(message, "NotSupportedError");

/** The version of a device as its descriptor has it: 0x0600. */
export const bcdDevice = ({ deviceVersionMajor, deviceVersionMinor, deviceVersionSubminor }: UsbDevice): number =>
  (deviceVersionMajor << 8) | (deviceVersionMinor << 4) | deviceVersionSubminor;
