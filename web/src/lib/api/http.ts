// HTTP requests to the program, and the error that a failed one raises.
/* eslint-disable @typescript-eslint/consistent-type-assertions -- here the JSON of the API gets the types of schema.ts; the server checks them */
import { localized } from "../i18n";
import type { Host } from "../platform/host";
import { clientId, clientName } from "./client";
import type * as Api from "./types";

const unexplained = (status: number): Api.Text => ({
  en: `The program answered with status ${status} and no explanation. Reload the page; if it happens again, report it.`,
  ru: `Программа ответила кодом ${status} без объяснения. Обновите страницу; если повторится, сообщите об этом.`,
});

export class ApiError extends Error {
  constructor(
    /** HTTP status; 0: there was no response. */
    readonly status: number,
    readonly code: string,
    readonly text: Api.Text,
    readonly sent: string | null = null,
    readonly received: string | null = null,
  ) {
    super(text.en);
    this.name = "ApiError";
  }

  /** The message with its advice, in the language on the screen. */
  get advice(): string {
    return localized(this.text);
  }
}

/** `each`: the name stands once for each text, which may have commas in it. */
export type Query = Record<string, string | number | boolean | string[] | { each: readonly string[] } | null | undefined>;

/** Relative to the page: the site is served under any path. */
export function address(path: string, query: Query = {}): string {
  const parts = Object.entries(query)
    .filter(([, value]) => value !== null && value !== undefined)
    .flatMap(([name, value]) => values(value).map((text) => `${name}=${encodeURIComponent(text)}`));
  return `api${path}${parts.length ? `?${parts.join("&")}` : ""}`;
}

const values = (value: Query[string]): readonly string[] =>
  typeof value === "object" && value !== null && "each" in value ? value.each : [String(value)];

export interface RequestOptions {
  query?: Query;
  body?: unknown;
  bytes?: BodyInit;
  signal?: AbortSignal;
}

/** What carries requests, and the words for when the program does not answer. */
export type Transport = Pick<Host, "fetch" | "words">;

/** Send a request and return its successful response. Throws `ApiError`, or the `AbortError` of the signal. */
async function send(host: Transport, method: string, path: string, options: RequestOptions = {}): Promise<Response> {
  const headers: Record<string, string> = { "X-Mikas-Client": clientId, "X-Mikas-Name": encodeURIComponent(clientName()) };
  let body: BodyInit | undefined = options.bytes;
  if (options.bytes !== undefined) headers["Content-Type"] = "application/octet-stream";
  else if (options.body !== undefined) {
    headers["Content-Type"] = "application/json";
    body = JSON.stringify(options.body);
  }
  return checked(host, address(path, options.query), { method, headers, body, signal: options.signal });
}

/** Fetch an address. An error is raised instead of being returned as a response. */
export async function checked(host: Transport, url: string, init: RequestInit): Promise<Response> {
  const response = await reached(host, host.fetch(url, init));
  if (!response.ok) throw await errorOf(response);
  return response;
}

/** What the network brings. Where it breaks off, the program is not reached. */
async function reached<T>(host: Transport, answer: Promise<T>): Promise<T> {
  try {
    return await answer;
  } catch (error) {
    if (error instanceof SyntaxError || (error instanceof DOMException && error.name === "AbortError")) throw error;
    throw new ApiError(0, "Unreachable", host.words.unreachable);
  }
}

async function errorOf(response: Response): Promise<ApiError> {
  try {
    const { error } = (await response.json()) as { error: Api.ErrorBody };
    if (typeof error.en !== "string") throw new TypeError("no text");
    return new ApiError(response.status, error.code, { en: error.en, ru: error.ru }, error.sent ?? null, error.received ?? null);
  } catch {
    return new ApiError(response.status, "Unexplained", unexplained(response.status));
  }
}

export async function json<T>(host: Transport, method: string, path: string, options?: RequestOptions): Promise<T> {
  const response = await send(host, method, path, options);
  return (response.status === 204 ? undefined : await reached(host, response.json())) as T;
}

/** Post a request that answers with newline-delimited JSON; `onLine` is called as each line arrives. */
export async function lines<T>(host: Transport, path: string, options: RequestOptions, onLine: (line: T) => void): Promise<void> {
  const response = await send(host, "POST", path, options);
  const reader = response.body!.pipeThrough(new TextDecoderStream()).getReader();
  let rest = "";
  for (;;) {
    const { value, done } = await reached(host, reader.read());
    if (done) break;
    const parts = (rest + value).split("\n");
    rest = parts.pop() ?? "";
    for (const part of parts) if (part.trim()) onLine(JSON.parse(part) as T);
  }
  if (rest.trim()) onLine(JSON.parse(rest) as T);
}
