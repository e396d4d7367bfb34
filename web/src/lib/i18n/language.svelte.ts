// The language of the page: the one selected here and stored; else that of the command line (`--lang`, which the server writes into the
// page); else the browser's.
import { loadSetting, saveSetting } from "../platform/storage";
import type { Text } from "../api/types";

export type Code = "en" | "ru";

function first(): Code {
  const chosen = loadSetting("language");
  if (chosen === "en" || chosen === "ru") return chosen;
  const named = globalThis.document?.documentElement.dataset.language;
  if (named === "en" || named === "ru") return named;
  const browser = globalThis.navigator?.language ?? "en";
  return /^(ru|be|kk|uk)/i.test(browser) ? "ru" : "en";
}

class Language {
  code = $state<Code>(first());

  get other(): Code {
    return this.code === "ru" ? "en" : "ru";
  }

  choose(code: Code): void {
    this.code = code;
    saveSetting("language", code);
    if (globalThis.document) document.documentElement.lang = code;
  }
}

export const language = new Language();
if (globalThis.document) document.documentElement.lang = language.code;

/** Return a text of the server in the selected language. */
export function localized(text: Text | null | undefined): string {
  return text ? text[language.code] : "";
}
