// Everything the page asks of the server. Each call gives what docs/api.md says or throws an ApiError whose text says what to do.
import { client, clientName } from "./client";
import { say } from "../i18n";
import type * as Api from "./types";

const unreachable: Api.Text = {
  en: "The mikas program does not answer. Is it still running? Look at the window it was started from.",
  ru: "Программа mikas не отвечает. Она ещё запущена? Посмотрите в окно, из которого её запускали.",
};

const strange = (status: number): Api.Text => ({
  en: `The program answered ${status} without an explanation. Reload the page; if it repeats, report it.`,
  ru: `Программа ответила ${status} без объяснения. Обновите страницу; если повторится, сообщите об этом.`,
});

export class ApiError extends Error {
  constructor(
    /** 0: no answer at all. */
    readonly status: number,
    readonly code: string,
    readonly text: Api.Text,
    readonly sent: string | null = null,
    readonly received: string | null = null,
  ) {
    super(text.en);
    this.name = "ApiError";
  }

  /** The whole advice in the language on the screen. */
  get said(): string {
    return say(this.text);
  }
}

export type Query = Record<string, string | number | boolean | string[] | null | undefined>;

export function address(path: string, query: Query = {}): string {
  const parts = Object.entries(query)
    .filter(([, value]) => value !== null && value !== undefined)
    .map(([name, value]) => `${name}=${encodeURIComponent(String(value))}`);
  return `/api${path}${parts.length ? `?${parts.join("&")}` : ""}`;
}

interface Options {
  query?: Query;
  body?: unknown;
  bytes?: BodyInit;
  signal?: AbortSignal;
}

async function ask(method: string, path: string, options: Options = {}): Promise<Response> {
  const headers: Record<string, string> = {
    "X-Mikas-Client": client,
    "X-Mikas-Name": encodeURIComponent(clientName()),
  };
  let body: BodyInit | undefined = options.bytes;
  if (options.bytes !== undefined) headers["Content-Type"] = "application/octet-stream";
  else if (options.body !== undefined) {
    headers["Content-Type"] = "application/json";
    body = JSON.stringify(options.body);
  }
  let answer: Response;
  try {
    answer = await fetch(address(path, options.query), { method, headers, body, signal: options.signal });
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    throw new ApiError(0, "Unreachable", unreachable);
  }
  if (!answer.ok) throw await refusal(answer);
  return answer;
}

async function refusal(answer: Response): Promise<ApiError> {
  try {
    const { error } = (await answer.json()) as { error: Api.ErrorBody };
    if (typeof error.en !== "string") throw new TypeError("no text");
    return new ApiError(
      answer.status,
      error.code,
      { en: error.en, ru: error.ru },
      error.sent,
      error.received,
    );
  } catch {
    return new ApiError(answer.status, "Strange", strange(answer.status));
  }
}

async function json<T>(method: string, path: string, options?: Options): Promise<T> {
  const answer = await ask(method, path, options);
  return (answer.status === 204 ? undefined : await answer.json()) as T;
}

/** Newline-delimited JSON: each line as it comes. */
async function lines<T>(path: string, options: Options, each: (line: T) => void): Promise<void> {
  const answer = await ask("POST", path, options);
  const reader = answer.body!.pipeThrough(new TextDecoderStream()).getReader();
  let rest = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) break;
    const parts = (rest + value).split("\n");
    rest = parts.pop() ?? "";
    for (const part of parts) if (part.trim()) each(JSON.parse(part) as T);
  }
  if (rest.trim()) each(JSON.parse(rest) as T);
}

const get = <T>(path: string, query?: Query, signal?: AbortSignal) =>
  json<T>("GET", path, { query, signal });
const post = <T>(path: string, body: unknown = {}, query?: Query) =>
  json<T>("POST", path, { body, query });
const put = <T>(path: string, body: unknown) => json<T>("PUT", path, { body });
const part = encodeURIComponent;

export const api = {
  state: () => get<Api.State>("/state"),
  about: () => get<Api.About>("/about"),
  takeControl: (force = false) => post<Api.State>("/control/take", { force }),
  releaseControl: () => post<Api.State>("/control/release"),

  catalog: () => get<Api.Catalog>("/catalog"),
  presets: () => get<{ presets: Api.Preset[] }>("/presets"),
  savePresets: (presets: Api.Preset[]) => put<{ presets: Api.Preset[] }>("/presets", { presets }),
  history: (seconds: number, points: number, names?: string[]) =>
    get<Api.History>("/history", { seconds, points, names }),

  ports: () => get<{ ports: Api.Port[] }>("/ports"),
  connect: (port: string | null) =>
    post<Api.State>("/connect", { port, echo: "auto", method: "auto", rate: null }),
  disconnect: () => post<Api.State>("/disconnect"),
  doctor: (port: string | null, each: (step: Api.DoctorStep) => void) =>
    lines<Api.DoctorStep>("/doctor", { body: { port } }, each),
  stopDoctor: () => post<Api.State>("/doctor/stop"),
  plan: (wanted: Api.Wanted[], method = "auto", rate: number | null = null) =>
    put<Api.State>("/plan", { wanted, method, rate }),
  price: (wanted: Api.Wanted[], method = "auto") =>
    post<Api.Price>("/plan/price", { wanted, method }),
  relearn: () => post<Api.State>("/relearn"),

  faults: () => get<Api.Faults>("/faults"),
  passport: () => get<Api.Passport>("/passport"),
  probe: () => post<Api.Passport>("/passport/probe"),
  memory: (space: Api.Space, first: number, count: number) =>
    get<Api.MemoryRead>(`/memory/${space}`, { address: `0x${first.toString(16)}`, count }),

  dumps: () => get<{ dumps: Api.Dump[] }>("/dumps"),
  dump: (id: string) => get<Api.Dump>(`/dumps/${part(id)}`),
  startDump: (space: Api.Space, first: number, last: number, block: number | null, verify: boolean) =>
    post<Api.Dump>("/dumps", { space, first, last, block, verify }),
  pauseDump: (id: string) => post<Api.Dump>(`/dumps/${part(id)}/pause`),
  resumeDump: (id: string) => post<Api.Dump>(`/dumps/${part(id)}/resume`),
  dumpFile: (id: string) => address(`/dumps/${part(id)}/file`),
  compareDump: (id: string, other: BodyInit, first: number) =>
    json<Api.Differences>("POST", `/dumps/${part(id)}/compare`, { bytes: other, query: { first } }),

  unlock: (minutes = 5) => post<Api.State>("/unlock", { minutes }),
  lock: () => post<Api.State>("/lock"),
  ask: (change: Api.Change) => post<Api.Asked>("/changes", change),
  confirm: (nonce: string) =>
    post<{ before: unknown; after: unknown; done: true }>(`/changes/${part(nonce)}`),
  journal: () => get<{ entries: Record<string, unknown>[] }>("/journal"),

  startRecording: (name: string | null = null) => post<Api.State>("/recording/start", { name }),
  stopRecording: () => post<Api.State>("/recording/stop"),
  marker: (label: string) => post<{ time: number }>("/recording/marker", { label }),
  note: (text: string) => post<unknown>("/recording/note", { text }),
  recordings: () => get<{ recordings: Api.Recording[]; problem: Api.Text | null }>("/recordings"),
  recording: (id: string) => get<Api.RecordingDetail>(`/recordings/${part(id)}`),
  rows: (
    id: string,
    query: { from: number; to: number; points: number; names?: string[] },
    signal?: AbortSignal,
  ) => get<Api.RecordingRows>(`/recordings/${part(id)}/rows`, query, signal),
  noteRecording: (id: string, text: string) => put<unknown>(`/recordings/${part(id)}/note`, { text }),
  recordingFile: (id: string) => address(`/recordings/${part(id)}/file`),
  exportFile: (id: string, format: Api.ExportFormat, names?: string[]) =>
    address(`/recordings/${part(id)}/export`, { format, names }),
  recordingReport: (id: string, lang: string, inline = false) =>
    address(`/recordings/${part(id)}/report`, { lang, inline: inline ? 1 : null }),
  report: (lang: string, inline = false) => address("/report", { lang, inline: inline ? 1 : null }),
};
