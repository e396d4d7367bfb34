// Which worker answers a request. Whatever keeps the CPU for long would stall the line, so the reader gets what only reads recordings: lists,
// windows of rows, searches, exports, reports, logs of other programs. All else needs the line, or changes a kept file, and only the line's worker may do that.
import type { Role } from "./messages";

const READING = [
  /^api\/recordings$/,
  /^api\/recordings\/[^/]+$/,
  /^api\/recordings\/[^/]+\/(rows|find|faults|causes|file|export|report)$/,
  /^api\/recordings\/[^/]+\/tests\/[^/]+$/,
];
/** These read a recording if one is named, else the last minutes of the line. */
const VALUE = /^api\/channels\/[^/]+\/value$/;
const TRIAL = "api/channels/try";
const FOREIGN = /^api\/foreign-logs\/[^/]+$/;

/** `address`: relative to the page. */
export function whoAnswers(method: string, address: string, body?: BodyInit | null): Role {
  const [path = "", query = ""] = address.split("?");
  const reads =
    method === "GET"
      ? READING.some((pattern) => pattern.test(path)) || (VALUE.test(path) && new URLSearchParams(query).has("recording"))
      : method === "POST" && (FOREIGN.test(path) || (path === TRIAL && namesRecording(body)));
  return reads ? "reader" : "line";
}

function namesRecording(body: BodyInit | null | undefined): boolean {
  try {
    const asked: unknown = typeof body === "string" ? JSON.parse(body) : null;
    return asked instanceof Object && "recording" in asked && typeof asked.recording === "string";
  } catch {
    return false;
  }
}
