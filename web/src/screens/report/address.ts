// The address of a report, of the session or of a recording.
import { api } from "../../lib/api/api";

export function reportAddress(recording: string | null, lang: string, inline: boolean): string {
  return recording === null
    ? api.report(lang, inline)
    : api.recordingReport(recording, lang, inline);
}

export function reportFile(recording: string | null, lang: string): string {
  const name = recording === null ? "mikas" : recording.replace(/\.pcapng$/, "");
  return `${name}-report-${lang}.html`;
}

/** Whether the server allows its own page to frame the report; if not, it is opened in a tab. */
export function mayFrame(headers: Headers): boolean {
  const policy = headers.get("content-security-policy") ?? "";
  const ancestors = /frame-ancestors ([^;]*)/.exec(policy)?.[1]?.trim();
  if (ancestors !== undefined) return ancestors !== "'none'";
  return headers.get("x-frame-options")?.toUpperCase() !== "DENY";
}
