// The file of a report, and whether the page may frame it.
import { recordingName } from "../../lib/recording/recordingData.svelte";

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
