// What the tests of the pool share.

import type { KeptFile } from "./slot";

interface Files {
  all(): Iterable<KeptFile>;
}

export function bytes(text: string): Uint8Array {
  return new TextEncoder().encode(text);
}

/** Return the files' texts by path. */
export function content(files: Files): Record<string, string> {
  return Object.fromEntries([...files.all()].map((file) => [file.path, textOf(file)]));
}

export function textOf(file: KeptFile): string {
  const into = new Uint8Array(file.size);
  file.read(into, 0);
  return new TextDecoder().decode(into);
}

export function find(files: Files, path: string): KeptFile {
  for (const file of files.all()) if (file.path === path) return file;
  throw new Error(`no file ${path}`);
}

/** Return what the promise is rejected with. */
export async function error(promise: Promise<unknown>): Promise<unknown> {
  return promise.then(
    () => null,
    (reason: unknown) => reason,
  );
}

/** Return numbers from 0 to 1, the same for the same seed. */
export function randoms(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let value = Math.imul(state ^ (state >>> 15), 1 | state);
    value = (value + Math.imul(value ^ (value >>> 7), 61 | value)) ^ value;
    return ((value ^ (value >>> 14)) >>> 0) / 2 ** 32;
  };
}
