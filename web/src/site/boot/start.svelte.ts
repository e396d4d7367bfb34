// What the page shows until the program runs.
import type { Progress } from "../program/messages";

/** Why the program can't run in this browser. */
export type Hindrance = "no-wasm" | "no-jspi";

/** Why the tab that has the program keeps it. */
export type Refusal = "recording" | "sampling" | "silent";

/** Why it did not start, as far as that is known: the recordings are in use, or of a later version; the browser does not answer; no network. */
export type Failure = "held" | "hangs" | "newer" | "offline" | "broken";

export type Start =
  | { kind: "loading"; progress: Progress | null }
  | { kind: "impossible"; why: Hindrance }
  | { kind: "broken"; message: string; why: Failure }
  /** Another tab has the program; `asked`: it was asked to leave it to this one. */
  | { kind: "elsewhere"; asked: boolean; refusal: Refusal | null };

class Shown {
  start = $state.raw<Start>({ kind: "loading", progress: null });
  /** In another tab: ask it to leave the program to this one. */
  ask: () => void = () => undefined;
  /** Load the page anew from its server; false: it can't be reached. */
  loadAnew: () => Promise<boolean> = () => Promise.resolve(false);
}

export const shown = new Shown();
