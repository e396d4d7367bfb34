// Whose report is shown, of the session or of a recording, and its file.
import { recordingName } from "../../lib/recording/recordingData.svelte";

/** In the screen's address: the connected car. No recording has this name. */
export const LIVE = "live";

/**
 * The recording that a report is of, null for the connected car: the one in the screen's address, or else the open one, so that the report
 * is on what the other screens show.
 */
export function reportSource(asked: string | undefined, open: string | null): string | null {
  if (asked === undefined) return open;
  return asked === LIVE ? null : asked;
}

export function reportFile(recording: string | null, lang: string): string {
  const name = recording === null ? "mikas" : recordingName(recording);
  return `${name}-report-${lang}.html`;
}

/** Whether the server allows its own page to frame the report; if not, it is opened in a tab. */
export function mayFrame(headers: Headers): boolean {
  const policy = headers.get("content-security-policy") ?? "";
  const ancestors = /frame-ancestors ([^;]*)/.exec(policy)?.[1]?.trim();
  if (ancestors !== undefined) return ancestors !== "'none'";
  return headers.get("x-frame-options")?.toUpperCase() !== "DENY";
}
