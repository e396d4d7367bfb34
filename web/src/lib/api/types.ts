// The API's types under the names that the page uses. They come from schema.ts, which is generated from the server's models. Events and
// messages of the live socket are not in the OpenAPI description; they are written here by hand.
import type { components } from "./schema";

type Schemas = components["schemas"];

/** A text in both languages. */
export type Text = Schemas["TwoTexts"];
export type ErrorBody = Schemas["ErrorBody"];

export type State = Schemas["State"];
export type Line = State["line"];
export type Rights = State["rights"];
export type Alarm = Schemas["ActiveAlarm"];
export type Level = Alarm["level"];
export type Plan = Schemas["PlanInfo"];
export type Method = Plan["method"];
export type Wanted = Schemas["PlannedChannel"];
export type RecordingNow = Schemas["RunningRecording"];
export type About = Schemas["AboutResponse"];

export type Catalog = Schemas["CatalogResponse"];
export type Channel = Schemas["Channel"];
export type Limits = Schemas["Limits"];
export type Preset = Schemas["Preset"];
export type Presets = Schemas["PresetList"];
export type Tile = Schemas["Tile"];
export type TileKind = Tile["kind"];

export type Port = Schemas["PortInfo"];
export type Ports = Schemas["PortsResponse"];
export type Price = Schemas["PriceResponse"];

export type Fault = Schemas["StoredFault"];
export type Faults = Schemas["FaultsResponse"];
export type Passport = Schemas["PassportResponse"];
export type MemoryRead = Schemas["MemoryResponse"];
export type Space = MemoryRead["space"];
export type Dump = Schemas["DumpResponse"];
export type Dumps = Schemas["DumpsResponse"];
export type Differences = Schemas["DifferencesResponse"];

export type Change =
  | Schemas["EraseFaults"]
  | Schemas["WriteParameter"]
  | Schemas["WriteMemory"]
  | Schemas["DeleteRecording"]
  | Schemas["DeleteDump"];
/** What a change would do; shown before a person confirms it with its nonce. */
export type ChangeProposal = Schemas["ChangeProposal"];
export type ChangeResult = Pick<Schemas["ChangeResult"], "before" | "after">;
export type Journal = Schemas["JournalResponse"];

export type Recording = Schemas["RecordingInfo"];
export type Recordings = Schemas["RecordingsResponse"];
export type RecordingRows = Schemas["RowsResponse"];
export type Rows = Pick<RecordingRows, "names" | "times" | "values">;
export type RecordingDetail = Omit<Schemas["RecordingDetail"], "events"> & { events: LineEvent[] };
export type History = Omit<Schemas["HistoryResponse"], "events"> & { events: LineEvent[] };
export type Marker = Schemas["MarkerResponse"];

// Written by hand from here on.

export type ExportFormat = "csv" | "mf4" | "parquet" | "msl" | "mlg";

/** A line of the response to POST /doctor. */
export interface DoctorStep {
  name: string;
  title: Text;
  ok: boolean | null;
  detail: Text;
  to_try: Text | null;
}

export type LineEvent =
  | { kind: "gap"; time: number; began: number; ended: number | null; reason: Text }
  | { kind: "state"; time: number; state: string; text: Text; reason: Text | null }
  | {
      kind: "alarm";
      time: number;
      name: string;
      level: Level | "none";
      before: Level | "none";
      side: Alarm["side"];
      value: number;
      limit: number;
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
  | { kind: "error"; time: number; text: Text; sent: string | null; received: string | null; code: string };

/** A message of the live socket. */
export interface LiveMessage {
  seq: number;
  now: number;
  dropped: number;
  state?: State;
  data?: Rows;
  events?: LineEvent[];
}
