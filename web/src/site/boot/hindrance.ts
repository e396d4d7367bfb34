// Whether the program can run in this browser at all.
import type { Hindrance } from "./start.svelte";

/** Null: it can. Blocking code of the program waits by JSPI: without it not even the virtual car runs. */
export function hindrance(): Hindrance | null {
  if (typeof WebAssembly !== "object") return "no-wasm";
  return "Suspending" in WebAssembly ? null : "no-jspi";
}
