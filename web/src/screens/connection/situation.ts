/**
 * Which of the well-known troubles this is. Each has its own words and its own picture, because
 * what to do differs: "not connected" alone helps nobody.
 */

import type { Port, State } from "../../lib/types";

export type Situation =
  | "off"
  | "no-cable"
  | "several"
  | "busy"
  | "denied"
  | "gone"
  | "no-port"
  | "elm327"
  | "no-echo"
  | "echo-only"
  | "ok";

const BY_CODE: Record<string, Situation> = {
  PortBusy: "busy",
  PortDenied: "denied",
  PortNotFound: "no-port",
  NoPortGiven: "several",
  PortFailed: "no-port",
  LinkLost: "gone",
  NoEcho: "no-echo",
  EchoOnly: "echo-only",
  NotAKLineAdapter: "elm327",
};

export function situationOf(
  state: Pick<State, "line" | "reason_code" | "port">,
  ports: readonly Port[] | null,
  code: string | null,
): Situation {
  if (state.line === "ecu-alive" || state.line === "sampling") return "ok";
  const told = code === null ? undefined : BY_CODE[code];
  if (told === "several" && ports && !ports.some((port) => port.likely)) return "no-cable";
  if (told) return told;
  // An ELM327 echoes nothing useful; only its reason tells it from an adapter with no 12 V, or why the connection was given up.
  if (state.reason_code === "NotAKLineAdapter") return "elm327";
  if (state.line === "no-echo" || state.line === "echo-only") return state.line;
  if (state.line === "no-port") return state.port ? "gone" : "no-cable";
  if (ports && !ports.some((port) => port.likely)) return "no-cable";
  return "off";
}

/** The likely ones first, as the server sorted them; the first likely one is the best guess. */
export function bestGuess(ports: readonly Port[]): Port | null {
  const likely = ports.filter((port) => port.likely);
  return likely.length > 0 ? (likely[0] ?? null) : null;
}
