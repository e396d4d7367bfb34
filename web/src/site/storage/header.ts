// The header of a pool file: which file it holds. Two copies of 4096 bytes, then the data.
//
// The copies are written in turns, and the valid one with the higher generation counts. So a write
// that was torn (a crash, a power failure) leaves the header as it was before. They are two blocks
// of the disk, as one block may be lost as a whole.
//
// A copy, little-endian:
//     0  8  "mikaskpt"
//     8  4  version of this format; a reader refuses a higher one whatever follows
//    12  4  CRC-32 of what comes before and after it, to the end of the path
//    16  8  generation: one more for each header written anywhere in the pool
//    24  8  id of the file, the generation in which it was made: st_ino; 0: the pool file is free
//    32  8  time of the last change, ms since 1970 (a float)
//    40  2  bytes of the path that follows, in UTF-8: "recordings/a.pcapng"

export const COPY = 4096;
export const DATA = 2 * COPY;
const PATH = 42;
export const LONGEST_PATH = 3000;
export const VERSION = 1;
const encoder = new TextEncoder();
const decoder = new TextDecoder();
const MAGIC = encoder.encode("mikaskpt");

export interface Header {
  generation: number;
  id: number;
  mtime: number;
  path: string;
}

/** Return one copy. */
export function encode(header: Header): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(COPY);
  const view = new DataView(bytes.buffer);
  const path = encoder.encode(header.path);
  bytes.set(MAGIC);
  view.setUint32(8, VERSION, true);
  view.setBigUint64(16, BigInt(header.generation), true);
  view.setBigUint64(24, BigInt(header.id), true);
  view.setFloat64(32, header.mtime, true);
  view.setUint16(40, path.length, true);
  bytes.set(path, PATH);
  view.setUint32(12, checksum(bytes, PATH + path.length), true);
  return bytes;
}

/** Return what a copy says: "newer" for a later format, null for one that is torn or was never written. */
export function decode(bytes: Uint8Array): Header | "newer" | null {
  if (bytes.length < COPY || MAGIC.some((byte, at) => bytes[at] !== byte)) return null;
  const view = new DataView(bytes.buffer, bytes.byteOffset, COPY);
  const version = view.getUint32(8, true);
  if (version > VERSION) return "newer";
  const length = view.getUint16(40, true);
  if (version !== VERSION || length > LONGEST_PATH) return null;
  if (view.getUint32(12, true) !== checksum(bytes, PATH + length)) return null;
  return {
    generation: Number(view.getBigUint64(16, true)),
    id: Number(view.getBigUint64(24, true)),
    mtime: view.getFloat64(32, true),
    path: decoder.decode(bytes.subarray(PATH, PATH + length)),
  };
}

const TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; bit++) value = value & 1 ? (value >>> 1) ^ 0xedb88320 : value >>> 1;
  return value;
});

function checksum(bytes: Uint8Array, end: number): number {
  let value = -1;
  for (let at = 0; at < end; at++) {
    const byte = at >= 12 && at < 16 ? 0 : bytes[at]!; // its own place
    value = (value >>> 8) ^ TABLE[(value ^ byte) & 255]!;
  }
  return ~value >>> 0;
}
