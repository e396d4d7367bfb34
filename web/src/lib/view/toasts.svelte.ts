// Short messages at the foot of the page. All go by themselves, and sooner when they are untrue by now; trouble stays in the band's list.
import { ApiError, api } from "../api/api";
import { dictionary } from "../i18n";

const t = dictionary({
  take: { en: "Take control", ru: "Взять управление" },
});

export interface Toast {
  id: number;
  kind: "done" | "trouble";
  /** Asked for at each drawing, so that it follows the language. */
  text: () => string;
  detail?: string;
  action?: { text: () => string; run: () => void };
  /** The class of the error it tells. */
  code?: string;
  /** ms that it stays. */
  lasts?: number;
}

export interface Past {
  /** UNIX seconds of this computer. */
  time: number;
  text: () => string;
  detail?: string;
}

const DONE = 4000;
const TROUBLE = 20_000;
const KEPT = 50;

class Toasts {
  shown = $state.raw<Toast[]>([]);
  private last = 0;

  /** Trouble that was told, the latest last. */
  past = $state.raw<Past[]>([]);

  done(text: () => string, more: Partial<Toast> = {}): void {
    this.show({ kind: "done", text, lasts: DONE, ...more });
  }

  trouble(text: () => string, more: Partial<Toast> = {}): void {
    this.past = [...this.past, { time: Date.now() / 1000, text, detail: more.detail }].slice(-KEPT);
    this.show({ kind: "trouble", text, lasts: TROUBLE, ...more });
  }

  /** What was in the way no longer is: what tells of it goes. */
  mended(codes: ReadonlySet<string>): void {
    this.shown = this.shown.filter(({ code }) => code === undefined || !codes.has(code));
  }

  close(id: number): void {
    this.shown = this.shown.filter((toast) => toast.id !== id);
  }

  private show(toast: Omit<Toast, "id">): void {
    const id = ++this.last;
    const said = toast.text();
    const others = this.shown.filter((before) => before.text() !== said).slice(-2);
    this.shown = [...others, { ...toast, id }];
    setTimeout(() => this.close(id), toast.lasts);
  }
}

export const toasts = new Toasts();

/**
 * Do it; say what went wrong. Undefined when it failed. Somebody else at the controls: the message has a button that takes
 * them and does it again.
 */
export async function attempt<T>(job: () => Promise<T>): Promise<T | undefined> {
  try {
    return await job();
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") return undefined;
    if (!(error instanceof ApiError)) throw error;
    const action =
      error.code === "NotController"
        ? {
            text: () => t("take"),
            run: () => void attempt(() => api.takeControl(true)).then((taken) => taken && attempt(job)),
          }
        : undefined;
    toasts.trouble(() => error.said, { action, detail: bytes(error), code: error.code });
    return undefined;
  }
}

function bytes(error: ApiError): string | undefined {
  if (!error.sent && !error.received) return undefined;
  return `→ ${error.sent ?? "–"}   ← ${error.received ?? "–"}`;
}
