// A change in two steps: the server says what would be done and what would be lost, a person confirms exactly that (its nonce). What is
// no longer as it was shown is shown again, never confirmed blindly.
import { ApiError, api } from "./api";
import { Asked } from "./request.svelte";
import { say } from "../i18n";
import type * as Api from "./types";

export interface Outcome {
  before: unknown;
  after: unknown;
}

export class TwoSteps {
  /** What is to be confirmed; null while it is being asked for. */
  readonly shown = new Asked<Api.Asked>();
  readonly done = new Asked<Outcome>();
  /** It was shown again because it had changed, or was too old. */
  again = $state(false);

  constructor(private readonly change: Api.Change) {}

  async begin(): Promise<void> {
    this.done.forget();
    await this.shown.ask(() => api.ask(this.change));
  }

  async confirm(): Promise<Outcome | undefined> {
    const asked = this.shown.value;
    if (!asked) return undefined;
    const outcome = await this.done.ask(() => api.confirm(asked.nonce));
    const error = this.done.error;
    if (error && isStale(error)) {
      this.again = true;
      await this.begin();
    }
    return outcome;
  }
}

export function isStale(error: ApiError): boolean {
  return error.code === "NonceStale" || error.code === "NonceUnknown";
}

/** One thing that a change takes away, in words, whatever form the server gives it. */
export function lostText(it: unknown): string {
  if (typeof it === "string" || typeof it === "number") return String(it);
  if (typeof it !== "object" || it === null) return "";
  const thing = it as { en?: unknown; ru?: unknown; code?: unknown; text?: unknown };
  const text =
    typeof thing.en === "string" && typeof thing.ru === "string"
      ? say({ en: thing.en, ru: thing.ru })
      : lostText(thing.text);
  const code = thing.code === undefined ? "" : String(thing.code);
  return [code, text].filter(Boolean).join(" · ");
}
