// Text to the clipboard. On a phone over plain http the browser has no clipboard for pages; the old way works there too.
import { copy } from "./saveFile";

export async function copyText(text: string): Promise<boolean> {
  return (await copy(text)) || bySelection(text);
}

function bySelection(text: string): boolean {
  const field = document.createElement("textarea");
  field.value = text;
  field.readOnly = true;
  field.className = "aloud";
  (document.querySelector("dialog[open]") ?? document.body).append(field);
  const before = document.activeElement;
  field.select();
  try {
    // Deprecated, and the only thing that works without a secure context.
    return document.execCommand("copy");
  } catch {
    return false;
  } finally {
    field.remove();
    if (before instanceof HTMLElement) before.focus();
  }
}
