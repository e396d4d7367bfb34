// Short messages at the foot of the page. They disappear after a while, or earlier when they no longer apply; errors stay in the band's
// list.
import type { ApiClient } from "../api/api";
import { ApiError } from "../api/http";
import type { Text } from "../api/types";
import { dictionary, localized } from "../i18n";
import { copyText, saveFile } from "../platform/output";

const t = dictionary({
  copied: { en: "Copied.", ru: "Скопировано." },
  saved: {
    en: "The browser refuses to copy. The text was saved as {file} instead.",
    ru: "Браузер не даёт копировать. Текст сохранён в файл {file}.",
  },
  refused: { en: "The browser refuses to copy.", ru: "Браузер не даёт копировать." },
  take: { en: "Take control", ru: "Взять управление" },
});

export interface Toast {
  id: number;
  kind: "success" | "error";
  /** Called at each drawing, so that it follows the language. */
  text: () => string;
  detail?: string;
  action?: { text: () => string; run: () => void };
  /** The class of the error that is shown. */
  code?: string;
  /** ms for which it is shown; Infinity: until it is closed. */
  duration?: number;
}

interface PastError {
  /** UNIX seconds of this computer. */
  time: number;
  text: () => string;
  detail?: string;
}

const SUCCESS_MS = 4000;
const ERROR_MS = 20_000;
const MAX_HISTORY = 50;

export class Toasts {
  shown = $state.raw<Toast[]>([]);
  private last = 0;
  private readonly reminded = new Set<string>();

  /** Errors that were shown, the latest last. */
  history = $state.raw<PastError[]>([]);

  constructor(private readonly api: ApiClient) {}

  success(text: () => string, more: Partial<Toast> = {}): void {
    this.show({ kind: "success", text, duration: SUCCESS_MS, ...more });
  }

  error(text: () => string, more: Partial<Toast> = {}): void {
    this.history = [...this.history, { time: Date.now() / 1000, text, detail: more.detail }].slice(-MAX_HISTORY);
    this.show({ kind: "error", text, duration: ERROR_MS, ...more });
  }

  /** Say what a person has to know who does not look now: each sentence once, until it is closed. */
  remind(sentences: Text[]): void {
    for (const sentence of sentences.filter(({ en }) => !this.reminded.has(en))) {
      this.reminded.add(sentence.en);
      this.error(() => localized(sentence), { duration: Infinity });
    }
  }

  /** Say why something can't be done now; that is no error, and stays in no list. */
  refuse(text: () => string, more: Partial<Toast> = {}): void {
    this.show({ kind: "error", text, duration: 6000, ...more });
  }

  /** Remove the messages of errors that no longer apply. */
  dismiss(codes: ReadonlySet<string>): void {
    this.shown = this.shown.filter(({ code }) => code === undefined || !codes.has(code));
  }

  close(id: number): void {
    this.shown = this.shown.filter((toast) => toast.id !== id);
  }

  private show(toast: Omit<Toast, "id">): void {
    const id = ++this.last;
    const text = toast.text();
    const others = this.shown.filter((before) => before.text() !== text);
    const passing = others.filter(({ duration }) => duration !== Infinity).slice(-2);
    this.shown = [...others.filter((before) => before.duration === Infinity || passing.includes(before)), { ...toast, id }];
    if (toast.duration !== Infinity) setTimeout(() => this.close(id), toast.duration);
  }

  /**
   * Run `job` and show its error as a toast. Returns undefined if it failed. If another client holds control, the toast offers to take
   * control and repeat.
   */
  async attempt<T>(job: () => Promise<T>): Promise<T | undefined> {
    try {
      return await job();
    } catch (error) {
      if (error instanceof DOMException && error.name === "AbortError") return undefined;
      if (!(error instanceof ApiError)) throw error;
      const take = () => void this.attempt(() => this.api.takeControl(true)).then((taken) => taken && this.attempt(job));
      const action = error.code === "NotController" ? { text: () => t("take"), run: take } : undefined;
      this.error(() => error.advice, { action, detail: bytes(error), code: error.code });
      return undefined;
    }
  }

  /**
   * Copy a text to the clipboard and say so (`said`). Where the browser refuses, the text is saved as `file`, so that it is not lost; without
   * a name the text is on the screen.
   */
  async copy(text: string, file: string | null, said: () => string = () => t("copied")): Promise<void> {
    if (await copyText(text)) return this.success(said);
    if (file === null) return this.refuse(() => t("refused"));
    saveFile(file, text);
    this.refuse(() => t("saved", { file }));
  }
}

function bytes(error: ApiError): string | undefined {
  if (!error.sent && !error.received) return undefined;
  return `→ ${error.sent ?? "–"}   ← ${error.received ?? "–"}`;
}
