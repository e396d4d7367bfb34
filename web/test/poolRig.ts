// What the tests of the pool share.

import type { KeptFile } from "../src/site/storage/slot";

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
