// The browser's own files (OPFS), as far as the pool uses them. Tests hand in others.
//
// In a dedicated worker only: elsewhere there are no sync access handles. Chromium reserves 1 MB for each
// open file that has grown, so the usage of `navigator.storage.estimate()` is above what is kept.

import { errno, FileError, StorageError } from "./errors";

/** An open file; a `FileSystemSyncAccessHandle` is one. */
export interface Handle {
  read(into: Uint8Array, options: { at: number }): number;
  write(bytes: Uint8Array, options: { at: number }): number;
  truncate(size: number): void;
  getSize(): number;
  flush(): void;
  close(): void;
}

/** "shared": others may have the file open, too, if they say the same, where the browser can do that. "alone": nobody else may. */
export type Holding = "shared" | "alone";

/** A file to read that another may have open, and writes. */
export interface View extends Handle {
  /** See how long the file is by now. */
  renew(): Promise<void>;
}

export interface Folder {
  names(): Promise<string[]>;
  /** Open the file, and make it if it is missing. Rejects with a `StorageError` if another holds it. */
  open(name: string, holding: Holding): Promise<Handle>;
  /** Look at a file that was made "shared". */
  view(name: string): Promise<View>;
}

// What is missing in TypeScript's types, or is there for workers only.
declare const FileSystemSyncAccessHandle: { prototype: object };
declare class FileReaderSync {
  readAsArrayBuffer(part: Blob): ArrayBuffer;
}
declare global {
  interface FileSystemFileHandle {
    createSyncAccessHandle(options: { mode: string }): Promise<Handle>;
  }
}

/** Handles that were asked something. Chromium never answers for one that is collected as garbage meanwhile, as at the start of Python. */
const asked = new Set<object>();

async function answered<T>(handle: object, answer: Promise<T>): Promise<T> {
  asked.add(handle);
  try {
    return await answer;
  } finally {
    asked.delete(handle);
  }
}

/** Return the site's folder of that name. Rejects with a `StorageError` if the browser has none. */
export async function opfsFolder(name = "pool"): Promise<Folder> {
  try {
    if (!("FileSystemSyncAccessHandle" in globalThis)) throw new Error("no sync access handles");
    const root = await navigator.storage.getDirectory();
    return new Opfs(await answered(root, root.getDirectoryHandle(name, { create: true })));
  } catch (error) {
    throw new StorageError("missing", error);
  }
}

class Opfs implements Folder {
  constructor(private readonly directory: FileSystemDirectoryHandle) {}

  async names(): Promise<string[]> {
    const names = [];
    for await (const name of this.directory.keys()) names.push(name);
    return names;
  }

  async open(name: string, holding: Holding): Promise<Handle> {
    const mode = holding === "shared" ? "readwrite-unsafe" : "readwrite";
    try {
      const file = await this.directory.getFileHandle(name, { create: true });
      return await answered(file, file.createSyncAccessHandle({ mode }));
    } catch (error) {
      const held = error instanceof DOMException && error.name === "NoModificationAllowedError";
      throw held ? new StorageError("held", error) : error;
    }
  }

  async view(name: string): Promise<View> {
    // Browsers without the property ignore the mode, and open alone.
    if ("mode" in FileSystemSyncAccessHandle.prototype)
      return Object.assign(await this.open(name, "shared"), { renew: () => Promise.resolve() });
    return Snapshot.of(await this.directory.getFileHandle(name));
  }
}

/** A file that another has open alone: what is in it is seen at once, how long it is by `renew`. */
class Snapshot implements View {
  private constructor(
    private readonly handle: FileSystemFileHandle,
    private file: File,
  ) {}

  static async of(handle: FileSystemFileHandle): Promise<Snapshot> {
    return new Snapshot(handle, await handle.getFile());
  }

  async renew(): Promise<void> {
    this.file = await this.handle.getFile();
  }

  read(into: Uint8Array, { at }: { at: number }): number {
    const bytes = new FileReaderSync().readAsArrayBuffer(this.file.slice(at, at + into.length));
    into.set(new Uint8Array(bytes));
    return bytes.byteLength;
  }

  getSize(): number {
    return this.file.size;
  }

  readonly write = refuse;
  readonly truncate = refuse;
  readonly flush = refuse;

  close(): void {}
}

function refuse(): never {
  throw new FileError(errno.ROFS);
}
