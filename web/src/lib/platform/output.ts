// Text and files out of the page: to the clipboard, or saved as a download. Over plain HTTP (a phone in the network) a page has no
// `navigator.clipboard`; selecting and copying works there.

/** Returns false if the browser refuses, so that the text can be shown instead. */
export async function copyText(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return copyBySelection(text);
  }
}

function copyBySelection(text: string): boolean {
  const field = document.createElement("textarea");
  field.value = text;
  field.readOnly = true;
  field.className = "visually-hidden";
  (document.querySelector("dialog[open]") ?? document.body).append(field);
  const before = document.activeElement;
  field.select();
  try {
    // Deprecated, but the only way without a secure context.
    return document.execCommand("copy");
  } catch {
    return false;
  } finally {
    field.remove();
    if (before instanceof HTMLElement) before.focus();
  }
}

/**
 * Copy an image (PNG) to the clipboard. Returns false if the browser refuses: over plain HTTP a page has no clipboard for images. The image is
 * made inside, because some browsers allow it only in the click itself.
 */
export async function copyImage(make: () => Promise<Blob>): Promise<boolean> {
  try {
    await navigator.clipboard.write([new ClipboardItem({ "image/png": make() })]);
    return true;
  } catch {
    return false;
  }
}

/** Save text or bytes made by the page as a download. */
export function saveFile(name: string, content: BlobPart, type = "text/plain;charset=utf-8"): void {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** Rows of cells as text for a spreadsheet: tabs between the cells, none inside, and no formula. */
export const tabbed = (rows: readonly (readonly (string | number)[])[]): string =>
  rows.map((cells) => cells.map((cell) => harmless(String(cell).replace(/[\t\r\n]+/g, " "))).join("\t")).join("\n") + "\n";

// The rule of `spreadsheet_text` (cleaning.py): what a spreadsheet would take for a formula begins with an apostrophe; a number stays one.
const FORMULA = /(^|;)([\s"'\u200b]*[=+\-@\uff1d\uff0b\uff0d\uff20][^;]+)/g;
const NUMBER = /^\s*[+-]?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?\s*$/;

const harmless = (cell: string): string =>
  cell.replace(FORMULA, (whole, before: string, text: string) => (NUMBER.test(text) ? whole : `${before}'${text}`));
