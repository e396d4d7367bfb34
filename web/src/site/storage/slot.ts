// One file of the pool: an open handle, the header in it, and whose data it holds.

import { errno, FileError, guarded } from "./errors";
import type { Handle } from "./folder";
import { COPY, DATA, decode, encode, type Header } from "./header";

/** "torn": there are data, and no header that says whose. "empty": just made, to be prepared. */
export type State = "used" | "free" | "empty" | "torn" | "newer";

const FREE: Header = { generation: 0, id: 0, mtime: 0, path: "" };
const both = new Uint8Array(DATA); // copies as they are read

export class Slot {
  /** The header that counts. */
  header = FREE;
  #next = 0; // the copy that is written next: the one that does not count

  constructor(
    readonly name: string,
    readonly handle: Handle,
  ) {}

  /** Bytes of data. */
  get size(): number {
    return Math.max(0, guarded(() => this.handle.getSize()) - DATA);
  }

  /** Read the header. */
  load(): State {
    const length = this.#read(both, 0);
    const first = decode(both.subarray(0, Math.min(COPY, length)));
    const second = decode(both.subarray(COPY, Math.max(COPY, length)));
    if (first === "newer" || second === "newer") return "newer";
    if (!first && !second) return this.size ? "torn" : "empty";
    const later = (second?.generation ?? -1) > (first?.generation ?? -1);
    this.header = (later ? second : first)!;
    this.#next = later ? 0 : 1;
    return this.header.id ? "used" : "free";
  }

  /** Take the room for both copies, so that later no full disk prevents renaming and deleting. */
  prepare(): void {
    const bytes = new Uint8Array(DATA);
    bytes.set(encode(FREE));
    if (this.#write(bytes, 0) < DATA) throw new FileError(errno.NOSPC);
    this.#next = 1;
  }

  /** Write the header: wholly, or the former one still counts. */
  save(header: Header): void {
    if (this.#write(encode(header), this.#next * COPY) < COPY) throw new FileError(errno.NOSPC);
    this.header = header;
    this.#next = 1 - this.#next;
  }

  read(into: Uint8Array, at: number): number {
    return this.#read(into, DATA + at);
  }

  /** Write what there is room for, at least a byte. */
  write(bytes: Uint8Array, at: number): number {
    const written = this.#write(bytes, DATA + at);
    if (bytes.length && !written) throw new FileError(errno.NOSPC);
    return written;
  }

  truncate(size: number): void {
    guarded(() => this.handle.truncate(DATA + size));
  }

  flush(): void {
    guarded(() => this.handle.flush());
  }

  #read(into: Uint8Array, at: number): number {
    return counted(into, () => this.handle.read(into, { at }));
  }

  #write(bytes: Uint8Array, at: number): number {
    return counted(bytes, () => this.handle.write(bytes, { at }));
  }
}

/** Chromium's own number for a full disk. */
const NO_SPACE = -8;

/** Return the number of bytes that `call` has done. Where it should throw, Chromium may return the number of its own error, without its sign. */
function counted(bytes: Uint8Array, call: () => number): number {
  const done = guarded(call);
  if (done <= bytes.length) return done;
  throw new FileError((done | 0) === NO_SPACE ? errno.NOSPC : errno.IO);
}

/** A file of the user's, in the slot that holds its data. */
export class KeptFile {
  /** How often it is open. */
  opened = 0;
  readonly id: number;
  mtime: number;
  /** Below the mount, without a slash before; null: it was deleted. */
  path: string | null;

  constructor(readonly slot: Slot) {
    this.id = slot.header.id;
    this.mtime = slot.header.mtime;
    this.path = slot.header.path;
  }

  get size(): number {
    return this.slot.size;
  }

  read(into: Uint8Array, at: number): number {
    return this.slot.read(into, at);
  }
}

const NAME = /^\d{3,}$/;

/** Whether a file of the folder belongs to the pool; the lock, for one, does not. */
export function isSlotName(name: string): boolean {
  return NAME.test(name);
}

/** Return the slots in use, and those that lost their path to another in a rename. */
export function winners(slots: Iterable<Slot>): { used: Slot[]; replaced: Slot[] } {
  const byPath = new Map<string, Slot>();
  const replaced: Slot[] = [];
  for (const slot of slots) {
    const other = byPath.get(slot.header.path);
    const later = !other || slot.header.generation > other.header.generation;
    if (later) byPath.set(slot.header.path, slot);
    const loser = later ? other : slot;
    if (loser) replaced.push(loser);
  }
  return { used: [...byPath.values()], replaced };
}
