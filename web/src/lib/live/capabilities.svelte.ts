// Whether an ECU can be asked, which one, and whether its adapter was unplugged.
import type { State } from "../api/types";
import { answering } from "./lineState";
import { live } from "./live.svelte";

/** Whether an ECU answers now. */
export const ecuAnswers = (): boolean => live.link === "open" && live.state !== null && answering(live.state);

/** A key that changes when another ECU is connected: data read from the previous one is no longer valid. */
export function ecuKey(): string {
  const state = live.state;
  return state ? JSON.stringify([state.port, state.version_code, state.passport]) : "";
}

/**
 * Whether the adapter was unplugged: data has come from it on this connection, so sampling resumes when it returns. A port that never
 * existed has to be selected instead.
 */
export function unplugged(state: Pick<State, "reason_code" | "model" | "samples">): boolean {
  return state.reason_code === "PortNotFound" && (state.samples > 0 || state.model !== null);
}
