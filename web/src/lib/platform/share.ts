// A file to another app, by the sheet of the phone or computer.
//
// Chromium decides by a list of its own which files may go, by name and by type: pictures, sound, films, PDF and text, at most 50 MB. Its
// `canShare` does not look at that list; `share` refuses what is not on it, and the touch is used up then. So a file of another kind goes as
// text from the start, with .txt behind its name; its bytes stay as they are.

const TYPES: Record<string, string> = { csv: "text/csv", html: "text/html", png: "image/png", svg: "image/svg+xml", txt: "text/plain" };
const MOST = 50 * 1024 * 1024;

/**
 * closed: the person closed the sheet, or it is still open. late: the touch is too long ago, so another one is needed. large, refused: the
 * browser does not take the file.
 */
export type Outcome = "shared" | "closed" | "late" | "large" | "refused";

/** The file as it can be shared. */
export function toShare(name: string, content: BlobPart): File {
  const type = TYPES[/[^.]*$/.exec(name)![0]];
  return type ? new File([content], name, { type }) : new File([content], `${name}.txt`, { type: TYPES.txt });
}

/** Whether this browser shares files at all. Over plain http, in Firefox and on Linux it does not. */
export function canShareFiles(): boolean {
  try {
    return navigator.canShare({ files: [toShare("a.txt", "a")] });
  } catch {
    return false;
  }
}

/** Show the sheet for `file`. Called in a touch, with nothing awaited before. */
export async function share(file: File): Promise<Outcome> {
  if (file.size > MOST) return "large";
  if (!navigator.userActivation.isActive) return "late";
  try {
    await navigator.share({ files: [file] });
    return "shared";
  } catch (error) {
    return error instanceof DOMException && ["AbortError", "InvalidStateError"].includes(error.name) ? "closed" : "refused";
  }
}
