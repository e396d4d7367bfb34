// What happened, in order of time, each once. On a bad line there are many events a second, and nearly all of them are new and the latest:
// such a one costs its own key and a place at the end, however many are held.
import type { LineEvent } from "../api/types";

const MOST = 2000;

export class EventLog {
  private readonly byKey = new Map<string, LineEvent>();
  private held: LineEvent[] = [];

  clear(): void {
    this.byKey.clear();
    this.held = [];
  }

  /** All that is held with these added. A gap is told when it begins and again when it has ended: then the later word holds. */
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
