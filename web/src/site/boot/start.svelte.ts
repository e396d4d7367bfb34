// What the page shows until the program runs.
import type { Progress } from "../program/messages";

/** Why the program can't run in this browser. */
export type Hindrance = "no-wasm" | "no-jspi";

/** Why the tab that has the program keeps it. */
export type Refusal = "recording" | "sampling" | "silent";

export type Start =
  | { kind: "loading"; progress: Progress | null }
  | { kind: "impossible"; why: Hindrance }
  | { kind: "broken"; message: string; offline: boolean }
  /** Another tab has the program; `asked`: it was asked to leave it to this one. */
  | { kind: "elsewhere"; asked: boolean; refusal: Refusal | null };

class Shown {
  start = $state.raw<Start>({ kind: "loading", progress: null });
  /** In another tab: ask it to leave the program to this one. */
  ask: () => void = () => undefined;
}

export const shown = new Shown();
