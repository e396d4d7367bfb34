// The API's types under the names that the page uses. They come from schema.ts, which is generated from the server's models.
import type { components } from "./schema";

type Schemas = components["schemas"];

/** A text in both languages. */
export type Text = Schemas["TwoTexts"];
export type ErrorBody = Schemas["ErrorBody"];

export type State = Schemas["State"];
export type Line = State["line"];
export type Alarm = Schemas["ActiveAlarm"];
export type Level = Alarm["level"];
export type Method = Schemas["PlanInfo"]["method"];
export type Wanted = Schemas["PlannedChannel"];
export type About = Schemas["AboutResponse"];

export type Catalog = Schemas["CatalogResponse"];
export type Channel = Schemas["ChannelInfo"];
export type ChannelKeys = Partial<Schemas["KeysRequest"]>;
export type NewLimits = Schemas["NewLimits"];
export type NewChannel = Schemas["ChannelRequest"];
export type ChannelValue = Schemas["ChannelValue"];
export type Trial = Schemas["TrialRequest"];
export type TrialResult = Schemas["TrialResponse"];
export type Limits = Schemas["ChannelLimits"];
export type Preset = Schemas["Preset"];
export type Presets = Schemas["PresetList"];
export type Tile = Schemas["Tile"];
export type TileKind = Tile["kind"];

export type Port = Schemas["PortInfo"];
export type Connecting = Schemas["ConnectRequest"];
export type VirtualCars = Schemas["VirtualCarsResponse"];
export type VirtualDefect = Schemas["VirtualDefect"];
export type CarAnswer = Schemas["AnswerResponse"];
export type Ports = Schemas["PortsResponse"];
export type Price = Schemas["PriceResponse"];

export type TestList = Schemas["TestList"];
export type TestInfo = Schemas["TestInfo"];
export type TestRunState = Schemas["TestRunState"];
export type TestRun = Schemas["TestRun"];
export type TestResults = Schemas["TestResults"];
export type TestVerdict = Schemas["TestVerdict"];
export type RecordedTest = Schemas["RecordedTest"];
export type TestCurve = Schemas["TestCurve"];

export type ForeignPreview = Schemas["ForeignPreview"];
export type ForeignLayout = Schemas["ForeignLayout"];
export type ForeignValues = Schemas["ForeignValues"];

export type Instruments = Schemas["InstrumentsResponse"];
export type Instrument = Schemas["InstrumentInfo"];
export type InstrumentDefinition = Schemas["InstrumentDefinitionInfo"];
export type NewInstrument = Schemas["NewInstrument"];
export type OwnInstrument = Schemas["OwnDefinition"];
export type Position = Schemas["Position"];

export type SurveyState = Schemas["SurveyState"];
export type SurveyRequest = Schemas["SurveyRequest"];
export type SurveyAnswer = Schemas["SurveyAnswerRequest"];
export type SurveyPrompt = Schemas["SurveyPrompt"];
export type SurveyResult = Schemas["SurveyResult"];
export type SavedSurvey = Schemas["SavedSurvey"];

export type Causes = Schemas["CausesResponse"];
export type Cause = Schemas["CauseInfo"];
export type CauseEvidence = Schemas["CauseEvidence"];
export type Complaint = Schemas["ComplaintInfo"]["name"];

export type Fault = Schemas["StoredFault"];
export type FreezeFrame = Schemas["FreezeFrameInfo"];
export type FreezeFrames = Schemas["FreezeFramesResponse"];
export type Faults = Schemas["FaultsResponse"];
export type RecordedFaults = Schemas["RecordedFaultsResponse"];
export type Passport = Schemas["PassportResponse"];
export type UnitCommand = Schemas["UnitCommand"];
export type MemoryRead = Schemas["MemoryResponse"];
export type Space = MemoryRead["space"];
export type Dump = Schemas["DumpResponse"];
export type Dumps = Schemas["DumpsResponse"];
export type LeftOutFile = Schemas["LeftOutFile"];

export type Change =
  | Schemas["EraseFaultsRequest"]
  | Schemas["WriteParameterRequest"]
  | Schemas["WriteMemoryRequest"]
  | Schemas["DeleteRecordingRequest"]
  | Schemas["DeleteDumpRequest"];
/** What a change would do; shown before a person confirms it with its nonce. */
export type ChangeProposal = Schemas["ChangeProposal"];
export type ChangeResult = Pick<Schemas["ChangeResult"], "before" | "after">;
export type ActionRule = Schemas["ActionModel"];
export type Actions = Schemas["ActionsResponse"];
export type ActionsToWrite = Schemas["ActionsRequest"];
export type ActionTrial = Schemas["ActionTrial"];
export type WritableParameter = Schemas["WritableParameter"];
export type Journal = Schemas["JournalResponse"];

export type Car = Schemas["CarInfo"];
export type UnitCar = Schemas["CarResponse"];
export type Found = Schemas["FoundResponse"];
export type KeptSearch = Schemas["KeptSearch"];
export type Searches = Schemas["SearchList"];

export type CoNow = Schemas["CoResponse"];
export type CoMeter = CoNow["meters"][number]["meter"];
export type CoStep = Schemas["CoStepResponse"];
export type CoStepRequest = Schemas["CoStepRequest"];

export type Pulls = Schemas["PullsResponse"];
export type Pull = Pulls["pulls"][number];
export type Trip = Schemas["TripResponse"];
export type TripSums = Schemas["TripSums"];
export type TripWay = Schemas["WayInfo"];

export type Recording = Schemas["RecordingInfo"];
export type Recordings = Schemas["RecordingsResponse"];
export type References = Schemas["ReferencesResponse"];
export type AddedRecording = Schemas["AddedRecording"];
export type VirtualReference = References["virtual"][number];
export type RecordingRows = Schemas["RowsResponse"];
export type RecordingDetail = Schemas["RecordingDetail"];
export type History = Schemas["HistoryResponse"];
export type Marker = Schemas["MarkerResponse"];
export type Markers = Schemas["MarkersResponse"];
export type NewMarker = Schemas["NewMarker"];

/** A line of the response to POST /doctor. */
export type DoctorStep = Schemas["DiagnosisStep"];

export type LiveMessage = Schemas["LiveMessage"];
export type Rows = Schemas["LiveRows"];
/** An event of live data or of a recording. */
export type LineEvent = History["events"][number] | RecordingDetail["events"][number];

/** Values of the query parameter `format` of an export. */
export type ExportFormat = "csv" | "mf4" | "parquet" | "msl" | "mlg" | "gpx" | "geojson";
