// What an event about the stored faults says that is new: for a message on every screen.
import type { LineEvent } from "../api/types";

export interface FaultNews {
  time: number;
  /** Numbers that the reading before did not have; null: no earlier event is known here. */
  added: number[] | null;
  codes: number[];
}

/** The news of the latest event about faults after `since`; null: none, or faults have only gone. */
export function faultNews(events: readonly LineEvent[], since: number): FaultNews | null {
  const readings = events.filter((event) => event.kind === "faults");
  const last = readings.at(-1);
  if (!last || last.time <= since) return null;
  const before = readings.at(-2);
  const added = before ? last.codes.filter((code) => !before.codes.includes(code)) : null;
  if (last.codes.length === 0 || added?.length === 0) return null;
  return { time: last.time, added, codes: last.codes };
}
