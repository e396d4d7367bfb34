// An adapter that is not there may never have been: then it has to be chosen. Or it was pulled: then the program goes on as soon as it is back.
import type { State } from "../api/types";

/** Only what was there can be unplugged: something came from it, on this connection. */
export function unplugged(state: Pick<State, "reason_code" | "model" | "samples">): boolean {
  return state.reason_code === "PortNotFound" && (state.samples > 0 || state.model !== null);
}
