// The kept files of the site: recordings, settings, dumps, in a pool of the browser's own files (OPFS).
//
//     const pool = await Pool.open(await opfsFolder());   // in a worker; rejects with a StorageError
//     mount(pyodide.FS, "/kept", pool);                   // from now on Python's open() and os work there
//     pool.close();                                       // not needed: a killed worker loses nothing
//
// Opening a file of OPFS is asynchronous, Python's open() is not. So all files of the pool are opened at
// the start, some more than are in use; a header in each says which file it holds (header.ts). Making,
// renaming and deleting are writes of headers. The pool grows before it runs dry. SQLite's VFS
// opfs-sahpool works the same way.
//
// Every write goes to the handle at once. What is on the disk after each single step, and what the
// next start makes of it:
//   make      header in a free slot, flush            before: no file; after: an empty one
//   rename    header with the new path, flush         before: the old name; after: the new one. If there
//             header of the replaced file is freed    was a file of that name the higher generation wins
//   delete    header freed, flush, data cut off       before: the file; after: none
// A flush holds this order on the disk, too, if the power fails: data that got there have their name.
//
// The pool has one writer. `view.ts` reads it in another worker meanwhile.

import { errno, FileError, StorageError } from "./errors";
import type { Folder, Handle } from "./folder";
import { type Header, LONGEST_PATH } from "./header";
import { isSlotName, KeptFile, Slot, type State, winners } from "./slot";

const LOCK = "lock";
/** Fewer free slots than this let the pool grow … */
const FEW = 16;
/** … to this many. */
const ENOUGH = 32;
/** Between two headers that only say that the file has changed, ms. */
const NOTED_EVERY = 1000;
/** How a recording begins. */
const PCAPNG = [0x0a, 0x0d, 0x0d, 0x0a];
const LONGEST_NAME = 255; // Emscripten's scandir cuts off the rest

export class Pool {
  /** Slots whose data have no whole header, and are no recording: kept as they are, and not used. */
  readonly damaged: string[] = [];
  readonly #files = new Set<KeptFile>();
  readonly #slots: Slot[] = [];
  readonly #free: Slot[] = []; // the first is used first, so a reader has time to see that a file is gone
  readonly #empty: Slot[] = []; // there was no room yet to prepare them
  #generation = 0;
  #growing: Promise<void> | null = null;
  #closed = false;

  private constructor(
    private readonly folder: Folder,
    private readonly lock: Handle,
    private readonly now: () => number,
  ) {}

  /** Open the pool, and make it if it is missing. Rejects with a `StorageError`. */
  static async open(folder: Folder, now: () => number = Date.now): Promise<Pool> {
    const pool = new Pool(folder, await folder.open(LOCK, "alone"), now);
    try {
      await pool.#load();
      await pool.#grow();
      return pool;
    } catch (error) {
      pool.close();
      throw error;
    }
  }

  /** All files. */
  all(): Iterable<KeptFile> {
    return this.#files;
  }

  /** Make an empty file of a name that is free. */
  create(path: string): KeptFile {
    check(path);
    const slot = this.#free[0];
    this.#growSoon();
    if (!slot) throw new FileError(errno.NFILE); // a moment later there are some
    if (slot.size) slot.truncate(0);
    this.#free.shift();
    const generation = ++this.#generation;
    try {
      slot.save({ generation, id: generation, mtime: this.now(), path });
      slot.flush();
    } catch (error) {
      this.#release(slot);
      throw error;
    }
    const file = new KeptFile(slot);
    this.#files.add(file);
    return file;
  }

  /** Rename the file; `replaced` had the name before. */
  rename(file: KeptFile, path: string, replaced: KeptFile | null): void {
    check(path);
    try {
      this.#note(file, path);
      file.slot.flush();
    } catch (error) {
      this.#restore(file);
      throw error;
    }
    file.path = path;
    if (!replaced) return;
    try {
      this.remove(replaced);
    } catch {
      this.#forget(replaced); // the next start frees it
    }
  }

  /** Delete the file; who has it open can still read and write. */
  remove(file: KeptFile): void {
    file.slot.save(this.#freed());
    this.#forget(file);
    if (!file.opened) this.#release(file.slot);
  }

  /** Note that the file is open once more. */
  hold(file: KeptFile): void {
    file.opened++;
  }

  /** Note that the file is open once less. */
  letGo(file: KeptFile): void {
    if (--file.opened) return;
    if (file.path === null) this.#release(file.slot);
    else this.#noteTime(file);
  }

  /** Write what there is room for, at least a byte. */
  write(file: KeptFile, bytes: Uint8Array, at: number): number {
    const written = file.slot.write(bytes, at);
    this.touch(file, this.now());
    return written;
  }

  truncate(file: KeptFile, size: number): void {
    file.slot.truncate(size);
    this.touch(file, this.now());
  }

  /** Set the time of the last change. */
  touch(file: KeptFile, mtime: number): void {
    file.mtime = mtime;
    if (Math.abs(mtime - file.slot.header.mtime) >= NOTED_EVERY) this.#noteTime(file);
  }

  /** Have the data and the header on the disk. */
  flush(file: KeptFile): void {
    this.#noteTime(file);
    file.slot.flush();
  }

  /** Let go of all files of the pool. */
  close(): void {
    this.#closed = true;
    for (const file of this.#files) this.#noteTime(file);
    for (const { handle } of this.#slots) handle.close();
    this.lock.close();
  }

  /** Wait until the pool has grown, if it does. */
  async grown(): Promise<void> {
    await this.#growing;
  }

  async #load(): Promise<void> {
    const names = (await this.folder.names()).filter(isSlotName);
    const opened = await Promise.allSettled(names.map((name) => this.#openSlot(name)));
    for (const each of opened) if (each.status === "rejected") throw each.reason;
    const states = this.#slots.map((slot) => ({ slot, state: slot.load() }));
    // Not before all were looked at: nothing is written to a pool of a newer format.
    if (states.some(({ state }) => state === "newer")) throw new StorageError("newer");
    const slots = (wanted: State) => states.filter((it) => it.state === wanted).map((it) => it.slot);
    this.#generation = Math.max(0, ...this.#slots.map((slot) => slot.header.generation));
    const { used, replaced } = winners(slots("used"));
    for (const slot of used) this.#files.add(new KeptFile(slot));
    for (const slot of [...slots("free"), ...replaced]) this.#release(slot);
    this.#empty.push(...slots("empty"));
    for (const slot of slots("torn")) if (!this.#recover(slot)) this.damaged.push(slot.name);
  }

  /** List a recording that has lost its header, and so its name; return false for other data. */
  #recover(slot: Slot): boolean {
    try {
      const begin = new Uint8Array(PCAPNG.length);
      slot.read(begin, 0);
      if (PCAPNG.some((byte, at) => begin[at] !== byte)) return false;
      const known = new Set([...this.#files].map(({ path }) => path));
      let path = `recordings/recovered ${slot.name}.pcapng`;
      for (let n = 2; known.has(path); n++) path = `recordings/recovered ${slot.name} (${n}).pcapng`;
      const generation = ++this.#generation;
      slot.save({ generation, id: generation, mtime: this.now(), path });
      slot.flush();
      this.#files.add(new KeptFile(slot));
      return true;
    } catch {
      return false; // the next start tries it again
    }
  }

  async #openSlot(name: string): Promise<Slot> {
    const handle = await this.folder.open(name, "shared");
    if (this.#closed) {
      handle.close();
      throw new FileError(errno.IO);
    }
    const slot = new Slot(name, handle);
    this.#slots.push(slot);
    return slot;
  }

  #growSoon(): void {
    if (this.#free.length > FEW || this.#growing) return;
    this.#growing = this.#grow().finally(() => (this.#growing = null));
  }

  async #grow(): Promise<void> {
    try {
      while (this.#free.length < ENOUGH) {
        if (!this.#empty.length) this.#empty.push(await this.#openSlot(this.#nextName()));
        this.#empty[0]!.prepare();
        this.#free.push(this.#empty.shift()!);
      }
    } catch {
      // No room, for one. What there is can be used, and the next file that is made tries it again.
    }
  }

  #nextName(): string {
    const last = Math.max(-1, ...this.#slots.map((slot) => Number(slot.name)));
    return String(last + 1).padStart(3, "0");
  }

  #release(slot: Slot): void {
    try {
      if (slot.header.id) slot.save(this.#freed());
      if (slot.size) {
        slot.flush();
        slot.truncate(0);
      }
      this.#free.push(slot);
    } catch {
      // Not used again before the next start.
    }
  }

  #forget(file: KeptFile): void {
    file.path = null;
    this.#files.delete(file);
  }

  /** Have a header that was not written wholly to the disk say again what holds. */
  #restore(file: KeptFile): void {
    try {
      this.#note(file, file.path!);
    } catch {
      // The former copy of the header counts, or the disk is gone.
    }
  }

  #note(file: KeptFile, path: string): void {
    file.slot.save({ generation: ++this.#generation, id: file.id, mtime: file.mtime, path });
  }

  /** Write the time of the last change, if it is another; a failure loses no data. */
  #noteTime(file: KeptFile): void {
    if (file.path === null || file.mtime === file.slot.header.mtime) return;
    try {
      this.#note(file, file.path);
    } catch {
      // The next change tries it again.
    }
  }

  #freed(): Header {
    return { generation: ++this.#generation, id: 0, mtime: 0, path: "" };
  }
}

function check(path: string): void {
  const size = (text: string) => new TextEncoder().encode(text).length;
  if (size(path) > LONGEST_PATH || path.split("/").some((name) => size(name) > LONGEST_NAME)) {
    throw new FileError(errno.NAMETOOLONG);
  }
}
