// What the state of the line says, in one word.
import type { State } from "../api/types";

/** Whether an ECU answers now. */
export const answering = ({ line }: Pick<State, "line">): boolean => line === "ecu-alive" || line === "sampling";

/** Whether the port is being opened: neither a state nor an error is known yet. */
export const opening = (state: Pick<State, "line" | "reason_code">): boolean => state.line === "no-port" && state.reason_code === null;

/** Whether an adapter of the device on which this page is, is plugged in and in use. */
export const holdsAdapter = ({ line, port }: Pick<State, "line" | "port">): boolean =>
  line !== "off" && line !== "no-port" && /^web(usb|serial):/.test(port ?? "");

/**
 * Whether the adapter was unplugged: data has come from it on this connection, so sampling resumes when it returns. A port that never
 * existed has to be selected instead.
 */
export function unplugged(state: Pick<State, "reason_code" | "model" | "samples">): boolean {
  return state.reason_code === "PortNotFound" && (state.samples > 0 || state.model !== null);
}
