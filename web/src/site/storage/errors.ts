// What can go wrong in the kept files: opening them at the start, and a call of Python's.

export type StorageReason =
  | "held" // another tab, or another worker, has them open
  | "newer" // a later version of the site wrote them; nothing was changed
  | "hangs" // the browser neither opens nor refuses them
  | "missing"; // this browser, or this private window, gives no files to a page

/** Why the kept files can't be opened. The texts for the user are the page's. */
export class StorageError extends Error {
  constructor(
    readonly reason: StorageReason,
    cause?: unknown,
  ) {
    super(`kept files: ${reason}`, { cause });
    this.name = "StorageError";
  }
}

/** The numbers of `errno` in Pyodide (those of WASI). */
export const errno = {
  EXIST: 20,
  INVAL: 28,
  IO: 29,
  NAMETOOLONG: 37,
  NFILE: 41,
  NOENT: 44,
  NOSPC: 51,
  NOTEMPTY: 55,
  ROFS: 69,
  STALE: 72,
  XDEV: 75,
} as const;

/** A file call that failed. Emscripten knows it by its name and makes Python's `OSError` of it. */
export class FileError extends Error {
  constructor(
    readonly errno: number,
    cause?: unknown,
  ) {
    super(`errno ${errno}`, { cause });
    this.name = "ErrnoError";
  }
}

/** Return what `call` returns; what the browser throws becomes a `FileError`. */
export function guarded<T>(call: () => T): T {
  try {
    return call();
  } catch (error) {
    if (error instanceof FileError) throw error;
    const full = error instanceof Error && error.name === "QuotaExceededError";
    throw new FileError(full ? errno.NOSPC : errno.IO, error);
  }
}
