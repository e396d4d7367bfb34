/**
 * Which of the well-known troubles this is. Each has its own words and its own picture, because
 * what to do differs: "not connected" alone helps nobody.
 */

import type { Port, State } from "../../lib/api/types";

export type Situation =
  | "off"
  | "opening"
  | "no-cable"
  | "several"
  | "busy"
  | "denied"
  | "gone"
  | "cut"
  | "over"
  | "no-port"
  | "deaf"
  | "unopened"
  | "elm327"
  | "no-echo"
  | "echo-only"
  | "ok";

const BY_CODE: Record<string, Situation> = {
  PortBusy: "busy",
  PortDenied: "denied",
  PortNotFound: "no-port",
  NoPortGiven: "several",
  PortFailed: "unopened",
  LinkLost: "gone",
  RecordingOver: "over",
  NoEcho: "no-echo",
  EchoOnly: "echo-only",
  NotAKLineAdapter: "elm327",
};

export type Told = Pick<State, "line" | "reason_code" | "port" | "model" | "samples">;

/**
 * `code`: of the last refusal to connect; `worked`: a port that something came from since the page was opened; `trying`: connecting is
 * on its way. The error's class decides; the line alone tells only that nothing is there.
 */
export function situationOf(
  state: Told,
  ports: readonly Port[] | null,
  code: string | null,
  worked: string | null = null,
  trying = false,
): Situation {
  if (trying) return "opening";
  if (answering(state.line)) return "ok";
  const none = ports !== null && !ports.some((port) => port.likely);
  const told = BY_CODE[state.reason_code ?? (state.line === "off" ? code : null) ?? ""];
  if (told === "several" && none) return "no-cable";
  if (told === "no-port" && wasThere(state, worked)) return "gone";
  if (told === "no-port" || told === "unopened") return far(state.port) ? "deaf" : told;
  if (told === "gone" && far(state.port)) return "cut";
  if (told) return told;
  if (state.line === "no-echo" || state.line === "echo-only") return state.line;
  if (state.line === "no-port") return state.reason_code ? "unopened" : "opening";
  return none ? "no-cable" : "off";
}

/** Whether a unit answers there now. */
export const answering = (line: State["line"]): boolean => line === "ecu-alive" || line === "sampling";

/** Only what was there can be unplugged. */
const wasThere = (state: Told, worked: string | null): boolean =>
  state.samples > 0 || state.model !== null || (worked !== null && worked === state.port);

/** An adapter that another computer shares. */
const far = (port: string | null): boolean => /^(socket|rfc2217):/.test(port ?? "");

/** The likely ones first, as the server sorted them; the first likely one is the best guess. */
export function bestGuess(ports: readonly Port[]): Port | null {
  const likely = ports.filter((port) => port.likely);
  return likely.length > 0 ? (likely[0] ?? null) : null;
}
