// Whether an ECU can be asked, and which one.
import { live } from "./live.svelte";

/** Whether an ECU answers now. */
export function ecuAnswers(): boolean {
  const line = live.state?.line;
  return live.link === "open" && (line === "ecu-alive" || line === "sampling");
}

/** A key that changes when another ECU is connected: data read from the previous one is no longer valid. */
export function ecuKey(): string {
  const state = live.state;
  return state ? JSON.stringify([state.port, state.version_code, state.passport]) : "";
}
