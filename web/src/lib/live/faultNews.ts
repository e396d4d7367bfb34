// What an event about the stored faults says that is new: for a message on every screen.
import type { LineEvent } from "../api/types";

export interface FaultNews {
  time: number;
  /** Numbers that the reading before did not have. */
  added: number[];
}

/** The news of the latest event about faults after `since`; null: none, or faults have only gone. */
export function faultNews(events: readonly LineEvent[], since: number): FaultNews | null {
  const last = events.findLast((event) => event.kind === "faults");
  if (!last || last.time <= since || !last.added?.length) return null;
  return { time: last.time, added: last.added };
}
