// The situations of the connection: one table of headline, advice and picture, so that these never contradict each other.

/**
 * What is known of a link of the chain. `check`: the advice names it as a possible cause. `missing`, `shut` (does not open), `wrong` (not
 * that kind) and `silent`: what fails.
 */
export type Mark = "works" | "check" | "missing" | "shut" | "wrong" | "silent" | "unknown";

export const LINKS = ["laptop", "adapter", "wire", "ecu"] as const;

interface Row {
  kind: "ok" | "info" | "danger";
  title: string;
  /** Null: the text of the program, which names the port, the error and its bytes. */
  advice: string | null;
  /** Of laptop, adapter, wire (K-Line and 12 V), ECU. */
  marks: readonly [Mark, Mark, Mark, Mark];
}

export const SITUATIONS = {
  ok: { kind: "ok", title: "s_ok", advice: null, marks: ["works", "works", "works", "works"] },
  /** A check without a connection reached the ECU. */
  reached: { kind: "ok", title: "s_reached", advice: "s_reached_do", marks: ["works", "works", "works", "works"] },
  off: { kind: "info", title: "s_off", advice: "s_off_do", marks: ["works", "unknown", "unknown", "unknown"] },
  opening: { kind: "info", title: "s_opening", advice: "s_opening_do", marks: ["works", "unknown", "unknown", "unknown"] },
  checking: { kind: "info", title: "s_checking", advice: "s_checking_do", marks: ["works", "unknown", "unknown", "unknown"] },
  "recording-ended": { kind: "info", title: "s_recording_ended", advice: null, marks: ["works", "unknown", "unknown", "unknown"] },
  several: { kind: "danger", title: "s_several", advice: "s_several_do", marks: ["works", "check", "unknown", "unknown"] },
  "no-cable": { kind: "info", title: "s_no_cable", advice: "s_no_cable_do", marks: ["works", "missing", "unknown", "unknown"] },
  /** The browser knows only the adapters that the user has chosen in its list. */
  "not-chosen": { kind: "info", title: "s_not_chosen", advice: "s_not_chosen_do", marks: ["works", "unknown", "unknown", "unknown"] },
  "out-of-reach": { kind: "info", title: "s_out_of_reach", advice: "s_out_of_reach_do", marks: ["works", "unknown", "unknown", "unknown"] },
  unplugged: { kind: "danger", title: "s_unplugged", advice: "s_unplugged_do", marks: ["works", "missing", "unknown", "unknown"] },
  /** The browser may have forgotten it. */
  "unplugged-chosen": {
    kind: "danger",
    title: "s_unplugged",
    advice: "s_unplugged_chosen_do",
    marks: ["works", "missing", "unknown", "unknown"],
  },
  "no-port": { kind: "danger", title: "s_no_port", advice: null, marks: ["works", "missing", "unknown", "unknown"] },
  "no-adapter": { kind: "danger", title: "s_no_adapter", advice: null, marks: ["works", "missing", "unknown", "unknown"] },
  closed: { kind: "danger", title: "s_closed", advice: null, marks: ["works", "missing", "unknown", "unknown"] },
  busy: { kind: "danger", title: "s_busy", advice: "s_busy_do", marks: ["works", "shut", "unknown", "unknown"] },
  "bridge-busy": { kind: "danger", title: "s_bridge_busy", advice: "s_bridge_busy_do", marks: ["works", "shut", "unknown", "unknown"] },
  denied: { kind: "danger", title: "s_denied", advice: "s_denied_do", marks: ["works", "shut", "unknown", "unknown"] },
  "not-openable": { kind: "danger", title: "s_not_openable", advice: null, marks: ["works", "shut", "unknown", "unknown"] },
  elm327: { kind: "danger", title: "s_elm327", advice: "s_elm327_do", marks: ["works", "wrong", "unknown", "unknown"] },
  "no-echo": { kind: "danger", title: "s_no_echo", advice: "s_no_echo_do", marks: ["works", "check", "check", "unknown"] },
  "echo-only": { kind: "danger", title: "s_echo_only", advice: "s_echo_only_do", marks: ["works", "works", "check", "silent"] },
  "bridge-silent": { kind: "danger", title: "s_no_echo", advice: "s_bridge_silent_do", marks: ["works", "check", "check", "unknown"] },
  "bridge-echo-only": { kind: "danger", title: "s_bridge_echo", advice: "s_bridge_echo_do", marks: ["works", "check", "check", "silent"] },
  /** Bytes come, but not those of an answer. */
  damaged: { kind: "danger", title: "s_damaged", advice: null, marks: ["works", "check", "check", "unknown"] },
  /** The ECU answers some requests. */
  disturbed: { kind: "danger", title: "s_disturbed", advice: null, marks: ["works", "works", "check", "works"] },
  "wrong-speed": { kind: "danger", title: "s_wrong_speed", advice: null, marks: ["works", "check", "check", "unknown"] },
} as const satisfies Record<string, Row>;

export type Situation = keyof typeof SITUATIONS;

/** The situation that an error names, by its class; of the line's state, of a request to connect, of a step of the check. */
export const BY_CODE: Readonly<Record<string, Situation>> = {
  PortBusy: "busy",
  PortProbed: "busy",
  PortTaken: "busy",
  AdapterTaken: "not-openable",
  TakenByBrltty: "not-openable",
  AdapterWithoutDriver: "not-openable",
  PortDenied: "denied",
  PortNotFound: "no-port",
  NoPortGiven: "several",
  PortFailed: "not-openable",
  OtherService: "not-openable",
  LinkLost: "unplugged",
  AnotherAdapter: "unplugged",
  RecordingOver: "recording-ended",
  NoEcho: "no-echo",
  ConnectionSilent: "no-echo",
  EchoOnly: "echo-only",
  NotAKLineAdapter: "elm327",
};
