// One function for each route of the API (docs/reference/api.md). Each returns the response's JSON or throws an `ApiError`.
import { address, checked, json as request, lines, type Query, type RequestOptions, type Transport } from "./http";
import type * as Api from "./types";
import { Waiting } from "./waiting";

const part = encodeURIComponent;

export type ApiClient = ReturnType<typeof createApi>;

/** The API of the program behind this host. */
export function createApi(host: Transport) {
  const waiting = new Waiting();
  const json = <T>(method: string, path: string, options: RequestOptions = {}) =>
    waiting.wait({ signal: options.signal, long: options.bytes !== undefined }, (signal) =>
      request<T>(host, method, path, { ...options, signal }),
    );
  const get = <T>(path: string, query?: Query, signal?: AbortSignal) => json<T>("GET", path, { query, signal });
  const post = <T>(path: string, body: unknown = {}, query?: Query) => json<T>("POST", path, { body, query });
  const put = <T>(path: string, body: unknown) => json<T>("PUT", path, { body });
  const remove = <T>(path: string, query?: Query) => json<T>("DELETE", path, { query });
  /** The folder of a recording, or what stands for the connected unit (null). */
  const of = (recording: string | null, connected: string) => (recording === null ? connected : `/recordings/${part(recording)}`);

  return {
    waiting,
    /** Fetch a file of the API by its address, so that an error can be shown instead of being saved as a file. */
    file: (url: string, signal?: AbortSignal) => waiting.wait({ signal, long: true }, (stop) => checked(host, url, { signal: stop })),

    state: () => get<Api.State>("/state"),
    about: () => get<Api.About>("/about"),
    takeControl: (force = false) => post<Api.State>("/control/take", { force }),

    catalog: () => get<Api.Catalog>("/catalog"),
    changeKeys: (name: string, keys: Api.ChannelKeys) => put<Api.Catalog>(`/channels/${part(name)}/keys`, keys),
    resetKeys: (name: string, keys: string[], version: string) => remove<Api.Catalog>(`/channels/${part(name)}/keys`, { keys, version }),
    changeChannel: (name: string, channel: Api.NewChannel) => put<Api.Catalog>(`/channels/${part(name)}`, channel),
    deleteChannel: (name: string, version: string) => remove<Api.Catalog>(`/channels/${part(name)}`, { version }),
    tryFormula: (trial: Api.Trial) => post<Api.TrialResult>("/channels/try", trial),
    channelValue: (name: string, recording: string | null, at: number | null) =>
      get<Api.ChannelValue>(`/channels/${part(name)}/value`, { recording, at }),
    presets: () => get<Api.Presets>("/presets"),
    savePresets: (presets: Api.Preset[]) => put<Api.Presets>("/presets", { presets }),
    history: (seconds: number, points: number, signal?: AbortSignal) => get<Api.History>("/history", { seconds, points }, signal),

    /** Moments at which a condition holds: in a recording, or in the live values (null). */
    find: (recording: string | null, expression: string) => get<Api.Found>(`${of(recording, "/history")}/find`, { expression }),
    searches: () => get<Api.Searches>("/searches"),
    saveSearches: (searches: Api.KeptSearch[]) => put<Api.Searches>("/searches", { searches }),

    ports: () => get<Api.Ports>("/ports"),
    virtualCars: () => get<Api.VirtualCars>("/virtual-cars"),
    /** What is wrong with a virtual car, by the `car` of its address. */
    carAnswer: (car: string) => get<Api.CarAnswer>("/virtual-cars/answer", { car }),
    connect: (port: string | null, more: Partial<Api.Connecting> = {}) =>
      post<Api.State>("/connect", { port, echo: "auto", method: "auto", rate: null, ...more }),
    disconnect: () => post<Api.State>("/disconnect"),
    /** `others`: where no Mikas answers, look for another kind of unit. */
    doctor: (port: string | null, onStep: (step: Api.DoctorStep) => void, others = false) =>
      waiting.wait({}, (signal, came) =>
        lines<Api.DoctorStep>(host, "/doctor", { body: { port, other_units: others }, signal }, (step) => {
          came();
          onStep(step);
        }),
      ),
    stopDoctor: () => post<Api.State>("/doctor/stop"),
    plan: (wanted: Api.Wanted[], method: Api.Method, rate: number | null) => put<Api.State>("/plan", { wanted, method, rate }),
    first: (names: readonly string[]) => put<Api.State>("/plan/first", { names }),
    price: (wanted: Api.Wanted[], method: Api.Method, first: readonly string[]) =>
      post<Api.Price>("/plan/price", { wanted, method, first }),
    relearn: () => post<Api.State>("/relearn"),

    tests: () => get<Api.TestList>("/tests"),
    testRun: () => get<Api.TestRunState>("/tests/run"),
    testResults: () => get<Api.TestResults>("/tests/results"),
    startTest: (name: string) => post<Api.TestRunState>(`/tests/${part(name)}/start`),
    skipTestStep: () => post<Api.TestRunState>("/tests/run/skip"),
    cancelTest: () => post<Api.TestRunState>("/tests/run/cancel"),
    recordedTest: (recording: string, test: string, signal: AbortSignal) =>
      get<Api.RecordedTest>(`/recordings/${part(recording)}/tests/${part(test)}`, undefined, signal),
    /** Of the connected car (null), or of a recording together with others of the same car. */
    causes: (recording: string | null, together: readonly string[], complaint: Api.Complaint | null, signal: AbortSignal) =>
      get<Api.Causes>(
        recording === null ? "/causes" : `/recordings/${part(recording)}/causes`,
        { complaint, with: { each: together } },
        signal,
      ),
    testInReport: (id: string, wanted: boolean) => put<Api.TestVerdict>(`/tests/results/${part(id)}`, { in_report: wanted }),

    survey: () => get<Api.SurveyState>("/survey"),
    startSurvey: (request: Api.SurveyRequest) => post<Api.SurveyState>("/survey/start", request),
    answerSurvey: (answer: Api.SurveyAnswer) => post<Api.SurveyState>("/survey/answer", answer),
    stopSurvey: () => post<Api.SurveyState>("/survey/stop"),
    surveyResult: () => get<Api.SurveyResult>("/survey/result"),
    saveSurvey: () => post<Api.SurveyState>("/survey/save"),
    forgetSurvey: () => remove<Api.SurveyState>("/survey"),
    surveyFile: () => address("/survey/file"),

    instruments: () => get<Api.Instruments>("/instruments"),
    addInstrument: (instrument: Api.NewInstrument) => post<Api.Instruments>("/instruments", instrument),
    removeInstrument: (name: string) => remove<Api.Instruments>(`/instruments/${part(name)}`),
    defineInstrument: (name: string, definition: Api.OwnInstrument) =>
      put<Api.Instruments>(`/instruments/definitions/${part(name)}`, definition),
    forgetDefinition: (name: string) => remove<Api.Instruments>(`/instruments/definitions/${part(name)}`),
    sendPosition: (position: Api.Position) => post<unknown>("/instruments/position", position),

    network: (on: boolean, control: boolean) => put<Api.About>("/network", { on, control }),
    end: () => post<Api.About>("/end"),
    networkQr: (host: string) => address("/about/qr.svg", { address: host }),
    freezeFrames: () => get<Api.FreezeFrames>("/freeze-frames"),
    freezeFrame: (id: string) => get<Api.Rows>(`/freeze-frames/${part(id)}`),
    deleteFreezeFrame: (id: string) => remove<Api.FreezeFrames>(`/freeze-frames/${part(id)}`),
    faults: () => get<Api.Faults>("/faults"),
    lastFaults: () => get<Api.Faults>("/faults", { last: true }),
    passport: () => get<Api.Passport>("/passport"),
    probe: () => post<Api.Passport>("/passport/probe"),
    memory: (space: Api.Space, first: number, count: number) =>
      get<Api.MemoryRead>(`/memory/${space}`, { address: `0x${first.toString(16)}`, count }),

    dumps: () => get<Api.Dumps>("/dumps"),
    dump: (id: string) => get<Api.Dump>(`/dumps/${part(id)}`),
    startDump: (space: Api.Space, first: number, last: number, block: number | null, verify: boolean) =>
      post<Api.Dump>("/dumps", { space, first, last, block, verify }),
    pauseDump: (id: string) => post<Api.Dump>(`/dumps/${part(id)}/pause`),
    resumeDump: (id: string) => post<Api.Dump>(`/dumps/${part(id)}/resume`),
    dumpFile: (id: string) => address(`/dumps/${part(id)}/file`),

    unlock: (minutes = 5) => post<Api.State>("/unlock", { minutes }),
    lock: () => post<Api.State>("/lock"),
    prepareChange: (change: Api.Change) => post<Api.ChangeProposal>("/changes", change),
    confirmChange: (nonce: string) => post<Api.ChangeResult>(`/changes/${part(nonce)}`),
    actions: () => get<Api.Actions>("/actions"),
    writeActions: (actions: Api.ActionsToWrite) => put<Api.Actions>("/actions", actions),
    tryAction: (rule: Api.ActionRule) => post<Api.ActionTrial>("/actions/try", rule),
    performAction: (name: string) => post<Api.Actions>(`/actions/${part(name)}/perform`),
    parameter: (name: string) => get<Api.WritableParameter>(`/parameters/${part(name)}`),
    co: () => get<Api.CoNow>("/co"),
    coStep: (body: Api.CoStepRequest) => post<Api.CoStep>("/co/step", body),
    journal: () => get<Api.Journal>("/journal"),

    startRecording: (name: string | null = null) => post<Api.State>("/recording/start", { name }),
    stopRecording: () => post<Api.State>("/recording/stop"),
    /** Mark this moment, or one that has passed. */
    marker: (label: string, time: number | null = null) => post<Api.Marker>("/recording/marker", { label, time }),
    /** Mark moments of a recording afterwards: all, or none. */
    markRecording: (id: string, markers: readonly Api.NewMarker[]) => post<Api.Markers>(`/recordings/${part(id)}/markers`, { markers }),
    nameMarker: (recording: string | null, time: number, label: string) =>
      put<Api.Marker>(`${of(recording, "/recording")}/marker`, { time, label }),
    removeMarker: (recording: string | null, time: number) => remove<Api.Marker>(`${of(recording, "/recording")}/marker`, { time }),
    note: (text: string) => post<unknown>("/recording/note", { text }),
    recordings: () => get<Api.Recordings>("/recordings"),
    addRecording: (name: string, file: Blob) => json<Api.AddedRecording>("POST", "/recordings", { query: { name }, bytes: file }),
    /** What a log of another program has. */
    foreignPreview: (file: File, settings: Query) =>
      json<Api.ForeignPreview>("POST", "/foreign-logs/preview", { query: { name: file.name, ...settings }, bytes: file }),
    foreignValues: (file: File, choice: Query) =>
      json<Api.ForeignValues>("POST", "/foreign-logs/values", { query: { name: file.name, ...choice }, bytes: file }),
    recording: (id: string) => get<Api.RecordingDetail>(`/recordings/${part(id)}`),
    rows: (id: string, query: { from: number | null; to: number | null; points: number; names?: string[] }, signal?: AbortSignal) =>
      get<Api.RecordingRows>(`/recordings/${part(id)}/rows`, query, signal),
    recordedFaults: (id: string) => get<Api.RecordedFaults>(`/recordings/${part(id)}/faults`),
    noteRecording: (id: string, text: string) => put<unknown>(`/recordings/${part(id)}/note`, { text }),
    car: () => get<Api.UnitCar>("/car"),
    writeCar: (recording: string | null, car: Api.Car) => put<Api.Car>(`${of(recording, "")}/car`, car),
    references: () => get<Api.References>("/references"),
    markReference: (id: string, on: boolean) => put<Api.References>(`/recordings/${part(id)}/reference`, { on }),
    recordingFile: (id: string) => address(`/recordings/${part(id)}/file`),
    exportFile: (id: string, format: Api.ExportFormat, names?: string[]) => address(`/recordings/${part(id)}/export`, { format, names }),
    /** The trip in a recording, or of the connected car (null), from the mark of that time on. */
    trip: (recording: string | null, since: number | null, colour: string, signal?: AbortSignal) =>
      get<Api.Trip>(`${of(recording, "")}/trip`, { since, colour }, signal),
    /** Power and torque from the pulls of a recording. `per_1000` null: a GPS has measured the speed. */
    pulls: (recording: string, car: { mass: number; per_1000: number | null; drag_area: number; slope: number }) =>
      get<Api.Pulls>(`/recordings/${part(recording)}/pulls`, car),
    wayFile: (recording: string | null, form: "gpx" | "geojson", since: number | null, lang: string) =>
      address(`${of(recording, "")}/trip/${form}`, { since, lang }),
    report: (recording: string | null, lang: string, inline = false) =>
      address(`${of(recording, "")}/report`, { lang, inline: inline ? 1 : null }),
  };
}
