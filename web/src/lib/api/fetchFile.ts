// A file of the server, as bytes: so that what can't be made is said on the screen, not saved as a file that holds an error.
import { ApiError } from "./api";
import { dictionary } from "../i18n";
import type { ErrorBody } from "./types";

const t = dictionary({
  failed: {
    en: "The file could not be fetched ({status}). Is mikas still running? Try again.",
    ru: "Не удалось получить файл ({status}). Программа mikas ещё запущена? Повторите.",
  },
});

export async function fetched(address: string, signal?: AbortSignal): Promise<Response> {
  let answer: Response | null = null;
  try {
    answer = await fetch(address, { signal });
    if (answer.ok) return answer;
    const { error } = (await answer.json()) as { error: ErrorBody };
    throw new ApiError(
      answer.status,
      error.code,
      { en: error.en, ru: error.ru },
      error.sent,
      error.received,
    );
  } catch (error) {
    if (error instanceof ApiError) throw error;
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    const said = t("failed", { status: String(answer?.status ?? "–") });
    throw new ApiError(answer?.status ?? 0, "Unreachable", { en: said, ru: said });
  }
}
