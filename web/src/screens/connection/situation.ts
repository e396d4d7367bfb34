// The situation of the connection. Each has its own text, picture and advice.

import type { Port, State } from "../../lib/api/types";

export type Situation =
  | "off"
  | "opening"
  | "no-cable"
  | "several"
  | "busy"
  | "denied"
  | "unplugged"
  | "closed"
  | "recording-ended"
  | "no-port"
  | "no-adapter"
  | "not-openable"
  | "elm327"
  | "no-echo"
  | "echo-only"
  | "ok";

const BY_CODE: Record<string, Situation> = {
  PortBusy: "busy",
  PortProbed: "busy",
  AdapterTaken: "not-openable",
  TakenByBrltty: "not-openable",
  AdapterWithoutDriver: "not-openable",
  PortDenied: "denied",
  PortNotFound: "no-port",
  NoPortGiven: "several",
  PortFailed: "not-openable",
  LinkLost: "unplugged",
  AnotherAdapter: "unplugged",
  RecordingOver: "recording-ended",
  NoEcho: "no-echo",
  EchoOnly: "echo-only",
  NotAKLineAdapter: "elm327",
};

export type Facts = Pick<State, "line" | "reason_code" | "port" | "model" | "samples">;

/**
 * Determine the situation. `code`: class of the last error of a connect request; `worked`: a port that data has come from since the page
 * was opened; `trying`: a connect request is running. The class of the error decides; the line's state alone does not name the cause.
 */
export function situationOf(
  state: Facts,
  ports: readonly Port[] | null,
  code: string | null,
  worked: string | null = null,
  trying = false,
): Situation {
  if (trying) return "opening";
  if (answering(state.line)) return "ok";
  const none = ports !== null && !ports.some((port) => port.likely);
  const known = BY_CODE[state.reason_code ?? (state.line === "off" ? code : null) ?? ""];
  if (known === "several" && none) return "no-cable";
  if (known === "no-port" && wasThere(state, worked)) return "unplugged";
  if (known === "no-port" || known === "not-openable") return isRemote(state.port) ? "no-adapter" : known;
  if (known === "unplugged" && isRemote(state.port)) return "closed";
  if (known) return known;
  if (state.line === "no-echo" || state.line === "echo-only") return state.line;
  if (state.line === "no-port") return state.reason_code ? "not-openable" : "opening";
  return none ? "no-cable" : "off";
}

/** Whether an ECU answers now. */
export const answering = (line: State["line"]): boolean => line === "ecu-alive" || line === "sampling";

/** Only an adapter that has delivered data counts as unplugged. */
const wasThere = (state: Facts, worked: string | null): boolean =>
  state.samples > 0 || state.model !== null || (worked !== null && worked === state.port);

/** An adapter shared by another computer. */
const isRemote = (port: string | null): boolean => /^(socket|rfc2217):/.test(port ?? "");

/** The first likely port; the server sorts by likelihood. */
export function bestGuess(ports: readonly Port[]): Port | null {
  const likely = ports.filter((port) => port.likely);
  return likely.length > 0 ? (likely[0] ?? null) : null;
}
