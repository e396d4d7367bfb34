// Bytes and addresses in hexadecimal, sixteen bytes a row with their characters. The four spaces and their ends are those of §3, rows
// 11–32.

import type { Space as SpaceName } from "../../../lib/api/types";

export type { SpaceName };

export interface Space {
  name: SpaceName;
  last: number;
  /** Read byte by byte: there is no block command for it (§3). */
  single: boolean;
}

export const SPACES: readonly Space[] = [
  { name: "ram", last: 0xff, single: false },
  { name: "xram", last: 0xffff, single: false },
  { name: "code", last: 0xffff, single: false },
  { name: "sfr", last: 0xff, single: true },
];

export const WIDTH = 16;

export function spaceOf(name: string): Space {
  const found = SPACES.find((space) => space.name === name);
  if (!found) throw new Error(`no memory space ${name}`);
  return found;
}

/** Parse `1F`, `0x1F` or `1Fh`; null for anything else. */
export function parseAddress(text: string): number | null {
  const trimmed = text.trim();
  const match = /^(?:0x([0-9a-f]{1,6})|([0-9a-f]{1,6})h?)$/i.exec(trimmed);
  if (!match) return null;
  return parseInt(match[1] ?? match[2] ?? "", 16);
}

/** The same within a space; null also beyond its end. */
export function addressIn(space: Space, text: string): number | null {
  const address = parseAddress(text);
  return address !== null && address <= space.last ? address : null;
}

/** How messages name a space and its last address. */
export const endOf = (space: Space) => ({ space: space.name.toUpperCase(), last: addressText(space.last, space) });

/** Parse `0A FF`, `0aff`, `0A:FF` or `0x0A, 0xFF`; null for anything else and for nothing. */
export function parseBytes(text: string): Uint8Array | null {
  const digits = text
    .replace(/0x/gi, " ")
    .replace(/[\s,:;]+/g, " ")
    .trim();
  if (!digits) return null;
  const out: number[] = [];
  for (const word of digits.split(" ")) {
    // A single digit is a byte; longer words consist of pairs.
    const whole = word.length === 1 ? `0${word}` : word;
    if (!/^(?:[0-9a-f]{2})+$/i.test(whole)) return null;
    for (let at = 0; at < whole.length; at += 2) out.push(parseInt(whole.slice(at, at + 2), 16));
  }
  return Uint8Array.from(out);
}

/** Bytes as the API expects them: upper-case hex without spaces. */
export function toHex(bytes: Iterable<number>): string {
  return Array.from(bytes, byteText).join("");
}

/** Bytes from the API's hex without spaces. */
export function fromHex(hex: string): Uint8Array {
  const out = new Uint8Array(hex.length >> 1);
  for (let at = 0; at < out.length; at++) out[at] = parseInt(hex.slice(at * 2, at * 2 + 2), 16);
  return out;
}

/** Format `0A FF 00`, cut after `longest` bytes. */
export function spaced(bytes: Uint8Array, longest = Infinity): string {
  const text = Array.from(bytes.subarray(0, longest), byteText).join(" ");
  return bytes.length > longest ? `${text} … (${bytes.length})` : text;
}

export function byteText(value: number): string {
  return value.toString(16).toUpperCase().padStart(2, "0");
}

/** Format `0040`, or `40` in a space of 256 bytes. */
export function addressText(address: number, space?: Space): string {
  const digits = space && space.last <= 0xff ? 2 : 4;
  return address.toString(16).toUpperCase().padStart(digits, "0");
}

export type Charset = "cp866" | "ascii";

const CP866 = new TextDecoder("ibm866");
const UPPER = Array.from({ length: 128 }, (_, at) => CP866.decode(Uint8Array.of(at + 128)));

/** The byte's character, `·` if it has none. Passports are written in cp866 (§3). */
export function character(value: number, charset: Charset): string {
  if (value >= 0x20 && value < 0x7f) return String.fromCharCode(value);
  // 0xFF is a no-break space in code page 866.
  if (charset === "cp866" && value >= 0x80 && value < 0xff) return UPPER[value - 128] ?? "·";
  return "·";
}

export interface Row {
  address: number;
  /** Sixteen cells; null where there is no byte. */
  cells: (number | null)[];
}

/** Rows that begin at multiples of sixteen. */
export function rowsOf(data: Uint8Array, first: number): Row[] {
  const rows: Row[] = [];
  const end = first + data.length;
  for (let address = first - (first % WIDTH); address < end; address += WIDTH) {
    const cells = Array.from({ length: WIDTH }, (_, column) => {
      const at = address + column - first;
      return at >= 0 && at < data.length ? (data[at] ?? null) : null;
    });
    rows.push({ address, cells });
  }
  return rows;
}

/** The bytes as text in the format of `mikas mem read`, for copying. */
export function dumpText(data: Uint8Array, first: number, charset: Charset): string {
  return rowsOf(data, first)
    .map(({ address, cells }) => {
      const hex = cells.map((cell) => (cell === null ? "  " : byteText(cell)));
      const characters = cells.map((cell) => (cell === null ? " " : character(cell, charset))).join("");
      const line = `${hex.slice(0, 8).join(" ")}  ${hex.slice(8).join(" ")}`;
      return `${addressText(address)}  ${line}  ${characters}`.trimEnd();
    })
    .join("\n");
}
