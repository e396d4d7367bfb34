// Copies a text to the clipboard and says so. Where the browser refuses, the text is saved as a file, so that it is not lost.
import { dictionary } from "../i18n";
import { copyText, saveFile } from "../platform/output";
import { toasts } from "./toasts.svelte";

const t = dictionary({
  copied: { en: "Copied.", ru: "Скопировано." },
  saved: {
    en: "The browser refuses to copy. The text was saved as {file} instead.",
    ru: "Браузер не даёт копировать. Текст сохранён в файл {file}.",
  },
  refused: { en: "The browser refuses to copy.", ru: "Браузер не даёт копировать." },
});

/** `file`: its name if it is saved; without one the text is on the screen. `said`: what is said when it was copied. */
export async function copy(text: string, file: string | null, said: () => string = () => t("copied")): Promise<void> {
  if (await copyText(text)) return toasts.success(said);
  if (file === null) return toasts.refuse(() => t("refused"));
  saveFile(file, text);
  toasts.refuse(() => t("saved", { file }));
}
