// A message for an instrument beside the unit that is lost or gives no values: its numbers are gone from the screen, and the unit's go on.
import { localized } from "../i18n";
import type { LineEvent } from "../api/types";
import type { Stores } from "../../stores";

/** s: an older event was news for an earlier page. */
const RECENT = 10;

/** Returns a function to be called with all events after each change. Of each instrument only the last state counts. */
export function instrumentTeller({ live, toasts }: Pick<Stores, "live" | "toasts">) {
  const told = new Map<string, number>();
  return (events: readonly LineEvent[]): void => {
    const last = new Map(events.flatMap((event) => (event.kind === "instrument" ? [[event.name, event] as const] : [])));
    for (const [name, { time, state, text }] of last) {
      if (live.now() - time > RECENT || (told.get(name) ?? -Infinity) >= time) continue;
      told.set(name, time);
      const code = `Instrument ${name}`;
      toasts.dismiss(new Set([code]));
      if (state === "lost" || state === "silent") toasts.error(() => localized(text), { code });
    }
  };
}
