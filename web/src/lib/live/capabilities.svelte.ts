// Whether there is anybody to ask, and who: said once, so that every screen takes it alike.
import { live } from "./live.svelte";

/** Is a unit there to be asked? */
export function ecuAnswers(): boolean {
  const line = live.state?.line;
  return live.link === "open" && (line === "ecu-alive" || line === "sampling");
}

/** Changes when another unit is at the line: what was read of the one before is not of this one. */
export function ecuKey(): string {
  const state = live.state;
  return state ? JSON.stringify([state.port, state.version_code, state.passport]) : "";
}
