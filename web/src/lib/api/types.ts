// What the server sends and takes. The description to read is docs/api.md (and /api/docs of a running program).

/** A text for people in both languages. */
export interface Text {
  en: string;
  ru: string;
}

export type Line = "off" | "no-port" | "no-echo" | "echo-only" | "ecu-alive" | "sampling";
export type Rights = "control" | "view";
export type Level = "warning" | "danger";

export interface Wanted {
  name: string;
  every: number;
}

export interface Plan {
  wanted: Wanted[];
  method: string;
  rate: number | null;
}

export interface Alarm {
  name: string;
  level: Level;
  side: "low" | "high";
  value: number;
  limit: number;
  since: number;
}

export interface RecordingNow {
  file: string;
  since: number;
  bytes: number;
  samples: number;
  gaps: number;
  failure: Text | null;
}

export interface State {
  line: Line;
  text: Text;
  /** What to try; stays while it is broken. */
  reason: Text | null;
  /** The class of that error: NoEcho, NotAKLineAdapter… */
  reason_code: string | null;
  since: number;
  port: string | null;
  adapter: string;
  model: Text | null;
  version_code: number | null;
  passport: (string | null)[] | null;
  method: string | null;
  rates: Record<string, number>;
  rate: number;
  bus_load: number;
  errors_minute: number;
  errors: number;
  samples: number;
  plan: Plan;
  dropped_parameters: string[];
  recording: RecordingNow | null;
  alarms: Alarm[];
  alarm_count: number;
  fault_count: number | null;
  controller: { id: string; name: string; you: boolean } | null;
  rights: Rights;
  viewers: number;
  unlocked_until: number | null;
  now: number;
  demo: boolean;
  lan: boolean;
}

/** Rows of samples: a value that was not fresh in its row is null. */
export interface Rows {
  names: string[];
  times: number[];
  values: (number | boolean | null)[][];
}

export type LineEvent =
  | { kind: "gap"; time: number; began: number; ended: number | null; reason: Text }
  | { kind: "state"; time: number; state: string; text: Text; reason: Text | null }
  | {
      kind: "alarm";
      time: number;
      name: string;
      level: Level | "none" | "ok" | "normal";
      before: string;
      side: "low" | "high" | null;
      value: number;
      limit: number | null;
      text: Text;
    }
  | { kind: "marker"; time: number; label: string }
  | { kind: "method"; time: number; method: string; rates: Record<string, number> }
  | { kind: "dropped"; time: number; name: string }
  | {
      kind: "unit";
      time: number;
      model: Text | null;
      version_code: number | null;
      passport: (string | null)[] | null;
      another: boolean;
    }
  | { kind: "recording"; time: number; file: string; on: boolean; failure: Text | null }
  | {
      kind: "error";
      time: number;
      text: Text;
      sent: string | null;
      received: string | null;
      code: string;
    };

export interface LiveMessage {
  seq: number;
  now: number;
  dropped: number;
  state?: State;
  data?: Rows;
  events?: LineEvent[];
  pong?: unknown;
}

export interface About {
  version: string;
  rights: Rights;
  demo: boolean;
  lan: boolean;
  url: string;
  lan_url: string | null;
  recordings_folder: string;
}

export interface Limits {
  danger_low: number | null;
  warning_low: number | null;
  warning_high: number | null;
  danger_high: number | null;
}

export interface Channel {
  name: string;
  derived: boolean;
  flag: boolean;
  code: number | null;
  size: number | null;
  unit: Text;
  text: Text;
  decimals: number;
  formula: string;
  range: [number, number] | null;
  reference: [number, number] | null;
  limits: Limits | null;
  lamp: { on: Text; off: Text } | null;
  alarm_when_true: "none" | Level;
  inputs: string[] | null;
  errata: { id: string; text: Text | string }[];
  confidence: string;
  writable: boolean;
}

export type TileKind = "gauge" | "number" | "lamp" | "strip" | "table";

export interface Tile {
  kind: TileKind;
  names: string[];
  span: 1 | 2 | 3;
}

export interface Preset {
  id: string;
  name: Text;
  shipped: boolean;
  tiles: Tile[];
}

export interface Catalog {
  version: string;
  parameters: Channel[];
  derived: Channel[];
  presets: Preset[];
}

export interface History extends Rows {
  events: LineEvent[];
}

export interface Port {
  url: string;
  description: string;
  chip: string | null;
  likely: boolean;
  /** What to know about its chip. */
  quirks?: Text[];
}

export interface DoctorStep {
  name: string;
  title: Text;
  ok: boolean | null;
  detail: Text;
  to_try: Text | null;
}

export interface Price {
  bytes: number;
  requests: number;
  seconds: number;
  rate: number;
  more: Record<string, { seconds: number; rate: number }>;
}

export interface Fault {
  code: number;
  text: Text;
  confidence: string;
  certain: boolean;
  /** A message, not a fault (12: self-diagnosis has begun). */
  informational?: boolean;
  check: Text | null;
  related: string[];
  first_seen: number;
}

export interface Faults {
  time: number;
  faults: Fault[];
  count: number;
}

export interface Passport {
  model: Text;
  version_code: number;
  program_passport: (string | null)[];
  data_passport: (string | null)[];
  parameter_count: number | null;
  adapter: string;
  port: string;
  echo: boolean;
  baud: number;
  latency_ms: number | null;
  limits: { max_list: number | null; max_block: Record<string, number>; refused: number[] };
  method: string;
  rates: Record<string, number>;
  supported:
    | { code: number; name: string; title: Text; source_name: string; supported: boolean | null }[]
    | null;
}

export type Space = "ram" | "xram" | "code" | "sfr";

export interface MemoryRead {
  space: Space;
  address: number;
  data: string;
  time: number;
}

export interface ErrorBody {
  code: string;
  en: string;
  ru: string;
  sent: string | null;
  received: string | null;
}

export interface Dump {
  id: string;
  space: Space;
  first: number;
  last: number;
  block: number | null;
  state: "running" | "paused" | "done" | "failed";
  done: number;
  total: number;
  speed: number;
  left: number | null;
  blocks: { first: number; count: number; state: "todo" | "done" | "retried" | "failed" }[];
  error: ErrorBody | null;
  file: string;
  differences: number | null;
}

export interface Differences {
  differences: { address: number; a: string | null; b: string | null }[];
  count: number;
}

export type Change =
  | { kind: "erase_faults" }
  | { kind: "write_parameter"; name: string; value: number }
  | { kind: "write_parameter"; name: string; raw: string }
  | { kind: "write_memory"; space: Space; address: number; data: string }
  | { kind: "delete_recording"; id: string }
  | { kind: "delete_dump"; id: string };

/** What a change would do, to be shown before it is confirmed with its nonce. */
export interface ChangeProposal {
  nonce: string;
  expires: number;
  what: Text;
  before: unknown;
  after: unknown;
  danger: boolean;
  lost: unknown[];
  meaning: Text | null;
}

export interface ChangeResult {
  before: unknown;
  after: unknown;
}

export interface Recording {
  id: string;
  bytes: number;
  date: number | null;
  length: number | null;
  model: Text | null;
  passport: (string | null)[] | null;
  samples: number;
  rate: number;
  gaps: number;
  faults: number[] | null;
  markers: number;
  note: string;
  /** Being recorded now. */
  open: boolean;
  problem: Text | null;
}

export interface RecordingDetail extends Recording {
  channels: string[];
  first: number;
  last: number;
  events: LineEvent[];
  problems: (Text & { offset: number })[];
  method: string | null;
}

export interface RecordingRows extends Rows {
  decimated: boolean;
  events?: LineEvent[];
}

export type ExportFormat = "csv" | "mf4" | "parquet" | "msl" | "mlg";
