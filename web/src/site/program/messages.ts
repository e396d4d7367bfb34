// The messages between the page and a worker that runs the program. `id`: chosen by the page, one for each request or socket.

import type { StorageReason } from "../storage/errors";

export type Headers = [name: string, value: string][];

export type ToWorker =
  | { kind: "request"; id: number; method: string; path: string; headers: Headers; body: ArrayBuffer | null }
  /** Nobody waits for the answer any more. */
  | { kind: "abort"; id: number }
  /** A WebSocket, on which only the program speaks. */
  | { kind: "open"; id: number; path: string }
  /** To the reader: what the line's worker does now. Sent when it changes, and before the first request. */
  | ({ kind: "situation" } & Situation)
  /** To the line's worker: the page is not shown any more, so others may have the adapters; or it is shown again. */
  | { kind: "release"; gone: boolean };

/** `recording`: the name of the file in progress; `catalog`: the version of the catalog in use, which may be kept anew. Null: none, not known. */
export interface Situation {
  recording: string | null;
  catalog: string | null;
}

export type FromWorker =
  /** The start: bytes of the program that are here, and what is being done. */
  | { kind: "progress"; loaded: number; total: number; stage: string }
  | { kind: "ready" }
  /** The program could not start, or can't go on. `why`: the kept files can't be opened. */
  | { kind: "broken"; message: string; why?: StorageReason }
  /** The answer to a request: its head, its body in parts, its end; or it failed without one. */
  | { kind: "head"; id: number; status: number; headers: Headers }
  | { kind: "body"; id: number; data: Uint8Array<ArrayBuffer> }
  | { kind: "end"; id: number }
  | { kind: "failed"; id: number; message: string }
  /** A WebSocket was accepted, has a message, is closed. */
  | { kind: "opened"; id: number }
  | { kind: "message"; id: number; data: string }
  | { kind: "closed"; id: number; code: number; reason: string };

export type Broken = Extract<FromWorker, { kind: "broken" }>;
export type Progress = Extract<FromWorker, { kind: "progress" }>;

/** The worker's name says what it does: holds the line and the storage, or only reads recordings. */
export type Role = "line" | "reader";

/** How the adapters are reached: by Web Serial, by WebUSB, or not at all. The page decides, and its workers learn it by their names. */
export type Access = "serial" | "usb" | "none";

export const nameOf = (role: Role, access: Access): string => `${role} ${access}`;

export function partsOf(name: string): [Role, Access] {
  const [role, access] = name.split(" ");
  return [role === "reader" ? "reader" : "line", access === "serial" || access === "usb" ? access : "none"];
}
