// Events ordered by time, without duplicates. A bad line produces many events a second, nearly all of them new and the latest: adding such
// an event costs one key and one place at the end, however many are stored.
import type { LineEvent } from "../api/types";

const MAX_EVENTS = 2000;

export class EventLog {
  private readonly byKey = new Map<string, LineEvent>();
  private events: LineEvent[] = [];

  clear(): void {
    this.byKey.clear();
    this.events = [];
  }

  /** Move all events and return them: the program's date was set. */
  move(seconds: number): readonly LineEvent[] {
    const moved = this.events.map((event) => movedEvent(event, seconds));
    this.clear();
    return this.add(moved);
  }

  /**
   * Add events and return all. A gap is reported when it begins and again when it has ended, a marker again with another name or as
   * removed; the second report replaces the first.
   */
  add(added: readonly LineEvent[]): readonly LineEvent[] {
    const events = [...this.events];
    let unordered = false;
    for (const event of added) {
      const key = keyOf(event);
      const before = this.byKey.get(key);
      if (event.kind === "marker" && event.removed) {
        if (before) events.splice(events.lastIndexOf(before), 1);
        this.byKey.delete(key);
        continue;
      }
      if (before) {
        if (!replaces(event, before)) continue;
        events[events.lastIndexOf(before)] = event;
      } else {
        const last = events.at(-1);
        unordered ||= last !== undefined && startOf(event) < startOf(last);
        events.push(event);
      }
      this.byKey.set(key, event);
    }
    if (unordered) events.sort((a, b) => startOf(a) - startOf(b));
    for (const dropped of events.splice(0, events.length - MAX_EVENTS)) this.byKey.delete(keyOf(dropped));
    return (this.events = events);
  }
}

function keyOf(event: LineEvent): string {
  if (event.kind === "gap") return `gap ${event.began}`;
  return event.kind === "marker" ? `marker ${event.time}` : JSON.stringify(event);
}

function replaces(event: LineEvent, before: LineEvent): boolean {
  if (event.kind === "marker" && before.kind === "marker") return event.label !== before.label;
  return event.kind === "gap" && before.kind === "gap" && before.ended === null;
}

/** The event that many seconds later, with a gap's begin and end. */
export function movedEvent(event: LineEvent, seconds: number): LineEvent {
  const time = event.time + seconds;
  if (event.kind !== "gap") return { ...event, time };
  return { ...event, time, began: event.began + seconds, ended: event.ended === null ? null : event.ended + seconds };
}

const startOf = (event: LineEvent): number => (event.kind === "gap" ? event.began : event.time);
