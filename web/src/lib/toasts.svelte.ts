// Short messages at the foot of the page. What matters stays until closed; "done" goes by itself.
import { ApiError, api } from "./api";
import { dictionary } from "./i18n";

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
}

class Toasts {
  shown = $state.raw<Toast[]>([]);
  private last = 0;

  done(text: () => string): void {
    const id = this.show({ kind: "done", text });
    setTimeout(() => this.close(id), 4000);
  }

  trouble(text: () => string, more: Partial<Toast> = {}): void {
    this.show({ kind: "trouble", text, ...more });
  }

  close(id: number): void {
    this.shown = this.shown.filter((toast) => toast.id !== id);
  }

  private show(toast: Omit<Toast, "id">): number {
    this.last += 1;
    const said = toast.text();
    const others = this.shown.filter((before) => before.text() !== said).slice(-2);
    this.shown = [...others, { ...toast, id: this.last }];
    return this.last;
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
    toasts.trouble(() => error.said, { action, detail: bytes(error) });
    return undefined;
  }
}

function bytes(error: ApiError): string | undefined {
  if (!error.sent && !error.received) return undefined;
  return `→ ${error.sent ?? "–"}   ← ${error.received ?? "–"}`;
}
