// A port that is missing may never have existed (then one must be selected) or its adapter was unplugged (then sampling resumes when it
// returns).
import type { State } from "../api/types";

/** Whether the adapter was unplugged: data has come from it on this connection. */
export function unplugged(state: Pick<State, "reason_code" | "model" | "samples">): boolean {
  return state.reason_code === "PortNotFound" && (state.samples > 0 || state.model !== null);
}
