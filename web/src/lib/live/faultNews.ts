// What an event about the stored faults says that is new: for a message on every screen.
import type { LineEvent } from "../api/types";

export interface FaultNews {
  event: LineEvent;
  /** Numbers that the reading before did not have. */
  added: number[];
}

/**
 * The news of the latest event about faults, unless that is `seen`; null: none, or faults have only gone. Not compared by their times: a
 * virtual car has another clock.
 */
export function faultNews(events: readonly LineEvent[], seen: LineEvent | null): FaultNews | null {
  const event = events.findLast((event) => event.kind === "faults");
  if (!event || event === seen || !event.added?.length) return null;
  return { event, added: event.added };
}
