// The program on a Python that has started: what it is handed, and its messages. Of the browser it needs nothing but timers, so tests run
// it under Node.
import type { PyodideAPI } from "pyodide";
import type { FromWorker, Headers, Role, ToWorker } from "../program/messages";
import { mount, type EmscriptenFs } from "../storage/mount";
import type { Pool } from "../storage/pool";
import type { PoolView } from "../storage/view";
import { waits } from "./waits";

/** Where the kept files are: Python's present folder, so that its errors do not name it. */
const KEPT = "/kept";

type Post = (message: FromWorker, transfer?: Transferable[]) => void;

/** Bytes and lists of Python, which are gone when the call returns. */
interface Lent<T> {
  toJs(): T;
}

/** The module `mikas.browser.start`. */
interface Start {
  prepare(host: object, runSync: unknown): void;
  begin: { callPromising(host: object, role: Role): Promise<(message: unknown) => void> };
}

/** What Python calls to answer: each is a message. */
const pageOf = (post: Post) => ({
  head: (id: number, status: number, headers: Lent<Headers>) => post({ kind: "head", id, status, headers: headers.toJs() }),
  body(id: number, bytes: Lent<Uint8Array<ArrayBuffer>>) {
    const data = bytes.toJs();
    post({ kind: "body", id, data }, [data.buffer]);
  },
  end: (id: number) => post({ kind: "end", id }),
  failed: (id: number, message: string) => post({ kind: "failed", id, message }),
  opened: (id: number) => post({ kind: "opened", id }),
  message: (id: number, data: string) => post({ kind: "message", id, data }),
  closed: (id: number, code: number, reason: string) => post({ kind: "closed", id, code, reason }),
});

/** Call `then` when Python has failed for good: out of memory, for one. Without that, whoever has asked it would wait for ever. */
export function endsWith(python: PyodideAPI, then: (error: unknown) => void): void {
  const inside: unknown = Reflect.get(python, "_api");
  if (inside instanceof Object) Reflect.set(inside, "on_fatal", then);
}

/**
 * Start the program, and return what takes the messages of the page. `files`: what is kept; null: in memory, gone with the tab. `more`: for
 * the module `mikas_host`, the adapters.
 */
export async function startProgram(
  python: PyodideAPI,
  role: Role,
  files: Pool | PoolView | null,
  post: Post,
  more: object = {},
): Promise<(message: ToWorker) => void> {
  // eslint-disable-next-line @typescript-eslint/consistent-type-assertions -- Emscripten's FS has more than its types say
  if (files) mount(python.FS as unknown as EmscriptenFs, KEPT, files);
  else python.FS.mkdirTree(KEPT);
  python.FS.chdir(KEPT);
  endsWith(python, (error) => post({ kind: "broken", message: String(error) }));
  const host = { ...waits, ...more, page: pageOf(post) };
  python.registerJsModule("mikas_host", host);
  // eslint-disable-next-line @typescript-eslint/no-unsafe-assignment -- its types are Python's
  const start: Start = python.pyimport("mikas.browser.start");
  start.prepare(host, python.pyimport("pyodide.ffi.run_sync"));
  const take = await start.begin.callPromising(host, role);
  return (message) => {
    const taken: unknown = python.toPy(message);
    take(taken);
    if (taken instanceof python.ffi.PyProxy) taken.destroy();
  };
}
