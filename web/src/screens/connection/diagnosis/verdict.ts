// The verdict on the connection, from the state of the line and from the connection check: the headline, the picture and the advice follow
// it. The line decides while it has a state; the check while it runs, and after it until the line has one again. A check that found more
// than a broken line tells refines it; one that contradicts the line is outdated.

import type { DoctorStep, Port, State } from "../../../lib/api/types";
import { answering, opening } from "../../../lib/live/lineState";
import { BY_CODE, SITUATIONS, type Mark, type Situation } from "./situations";
import { passed } from "./steps";

export type LineFacts = Pick<State, "line" | "reason_code" | "port" | "model" | "samples">;

/**
 * What else is known. `code`: class of the last error of a request to connect, or to check; `worked`: a port that data has come from since
 * the page was opened; `trying`: a request to connect is running; `adapters`: the program finds them,
 * the user has chosen them in a list of the browser, or they can't be used.
 */
export interface Circumstances {
  ports: readonly Port[] | null;
  code: string | null;
  worked?: string | null;
  trying?: boolean;
  adapters?: "found" | "chosen" | "out-of-reach";
}

/** The check: of `port`, with the steps so far. */
export interface Check {
  running: boolean;
  port: string | null;
  steps: readonly DoctorStep[];
}

export interface Verdict {
  situation: Situation;
  marks: readonly Mark[];
  /** The step of the check that the verdict is from; null: it is from the line. */
  step: DoctorStep | null;
  /** The check's result is not the present state. */
  outdated: boolean;
}

/** Findings of the check that are more exact than these states of the line. */
const REFINES: Partial<Record<Situation, readonly Situation[]>> = {
  "wrong-speed": ["echo-only", "no-echo", "bridge-echo-only", "bridge-silent", "damaged"],
  damaged: ["echo-only", "bridge-echo-only"],
};

export function verdictOf(state: LineFacts, circumstances: Circumstances, check: Check | null): Verdict {
  const result = check && finding(check.steps, check.port);
  if (circumstances.trying) return verdict("opening");
  if (check?.running) return { ...verdict("checking"), marks: result ? SITUATIONS[result.situation].marks : progress(check.steps) };
  const line = situationOf(state, circumstances);
  if (!result || (state.port !== null && check.port !== null && state.port !== check.port)) return verdict(line);
  if (!hasState(state)) return verdict(result.situation === "ok" ? "reached" : result.situation, result.step);
  if (result.situation === line) return verdict(line);
  if (REFINES[result.situation]?.includes(line)) return verdict(result.situation, result.step);
  return { ...verdict(line), outdated: !(result.situation === "disturbed" && line === "ok") };
}

const verdict = (situation: Situation, step: DoctorStep | null = null): Verdict => ({
  situation,
  marks: SITUATIONS[situation].marks,
  step,
  outdated: false,
});

/** The result of a check that has ended; null: it was stopped. */
function finding(steps: readonly DoctorStep[], port: string | null): { situation: Situation; step: DoctorStep | null } | null {
  const failed = steps.find(({ ok }) => ok === false);
  if (!failed) return passed(steps) ? { situation: "ok", step: null } : null;
  const last = steps.findLast(({ ok }) => ok === false)!;
  const known = BY_CODE[last.code ?? ""];
  if (known) return { situation: remote(known, port), step: last };
  const answered = steps.some(({ name, ok }) => name === "ecu" && ok === true);
  if (answered)
    return failed.name === "line" || last.name === "commands" ? { situation: "disturbed", step: last } : { situation: "ok", step: null };
  if (failed.name === "port") return { situation: remote("not-openable", port), step: failed };
  return { situation: failed.name === "baud" ? "wrong-speed" : "damaged", step: failed };
}

/** The picture while the check runs: only what a step has shown to work. */
function progress(steps: readonly DoctorStep[]): readonly Mark[] {
  const has = (name: string) => steps.some((step) => step.name === name && step.ok === true);
  const reached = has("latency") || has("line") || has("ecu") ? 4 : has("echo") ? 2 : 1;
  return SITUATIONS.ok.marks.map((mark, at) => (at < reached ? mark : "unknown"));
}

/** Whether the line has a state or an error: not while nothing is connected, or a port is being opened. */
const hasState = ({ line, reason_code }: LineFacts): boolean => reason_code !== null || (line !== "off" && line !== "no-port");

/** The situation of the line. The class of the error decides; the line's state alone does not name the cause. */
export function situationOf(state: LineFacts, { ports, code, worked = null, adapters = "found" }: Circumstances): Situation {
  if (answering(state)) return "ok";
  const without = ({ found: "no-cable", chosen: "not-chosen", "out-of-reach": "out-of-reach" } as const)[adapters];
  const gone = adapters === "chosen" ? "unplugged-chosen" : "unplugged";
  const none = ports !== null && !ports.some((port) => port.likely);
  const known = BY_CODE[state.reason_code ?? (state.line === "off" ? code : null) ?? ""];
  if (known === "several" && none) return without;
  if (known === "no-port" && wasThere(state, worked)) return gone;
  if (known) return known === "unplugged" && adapters === "chosen" ? gone : remote(known, state.port);
  if (state.line === "echo-only" && state.reason_code !== null) return "damaged";
  if (state.line === "no-echo" || state.line === "echo-only") return remote(state.line, state.port);
  if (state.line === "no-port") return opening(state) ? "opening" : remote("not-openable", state.port);
  return none ? without : "off";
}

/** Only an adapter that has delivered data counts as unplugged. */
const wasThere = (state: LineFacts, worked: string | null): boolean =>
  state.samples > 0 || state.model !== null || (worked !== null && worked === state.port);

/** The same of an adapter behind a bridge in the network, or shared by another computer. */
const REMOTE: Partial<Record<Situation, Situation>> = {
  "no-port": "no-adapter",
  "not-openable": "no-adapter",
  unplugged: "closed",
  busy: "bridge-busy",
  "no-echo": "bridge-silent",
  "echo-only": "bridge-echo-only",
};

function remote(situation: Situation, port: string | null): Situation {
  return /^(socket|rfc2217):/.test(port ?? "") ? (REMOTE[situation] ?? situation) : situation;
}

/** The first likely port; the server sorts by likelihood. */
export const bestGuess = (ports: readonly Port[]): Port | null => ports.find((port) => port.likely) ?? null;
