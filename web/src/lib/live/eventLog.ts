// Events ordered by time, without duplicates. A bad line produces many events a second, nearly all of them new and the latest: adding such
// an event costs one key and one place at the end, however many are stored.
import type { LineEvent } from "../api/types";

const MOST = 2000;

export class EventLog {
  private readonly byKey = new Map<string, LineEvent>();
  private held: LineEvent[] = [];

  clear(): void {
    this.byKey.clear();
    this.held = [];
  }

  /** Add events and return all. A gap is reported when it begins and again when it has ended; the second report replaces the first. */
  add(events: readonly LineEvent[]): readonly LineEvent[] {
    const held = [...this.held];
    let back = false;
    for (const event of events) {
      const key = keyOf(event);
      const before = this.byKey.get(key);
      if (before) {
        if (event.kind !== "gap" || before.kind !== "gap" || before.ended !== null) continue;
        held[held.lastIndexOf(before)] = event;
      } else {
        const last = held.at(-1);
        back ||= last !== undefined && begun(event) < begun(last);
        held.push(event);
      }
      this.byKey.set(key, event);
    }
    if (back) held.sort((a, b) => begun(a) - begun(b));
    for (const gone of held.splice(0, held.length - MOST)) this.byKey.delete(keyOf(gone));
    return (this.held = held);
  }
}

const keyOf = (event: LineEvent): string => (event.kind === "gap" ? `gap ${event.began}` : JSON.stringify(event));

const begun = (event: LineEvent): number => (event.kind === "gap" ? event.began : event.time);
