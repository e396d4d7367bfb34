// How far a value can be believed. Its own period is known (the plan and the rate of now): fresh for four of them, then stale with its age; after
// twelve, or in a gap, or when the line is broken, there is no value: a dash, never the last number. Half a second is granted to the way here.
import { live, type Latest } from "../live/live.svelte";
import { display } from "./source.svelte";

export type DisplayValue =
  | { kind: "fresh"; value: number }
  | { kind: "stale"; value: number; age: number }
  | { kind: "none" };

const NONE: DisplayValue = { kind: "none" };

/** Granted in any case: what messages and the unit's own answers vary by, and until when a value is kept, faded, at least. */
const MIN_FRESH = 0.5;
const MIN_STALE = 3;
/** Of a recording, and before a rate is known, whose period is not. */
const UNKNOWN_PERIOD = { fresh: 1, stale: 10 };

/** By its age and its own period; 0: not known. */
export function displayValueOf(latest: Latest | undefined, now: number, period: number): DisplayValue {
  if (!latest) return NONE;
  const age = now - latest.time;
  const fresh = period > 0 ? Math.max(MIN_FRESH, 4 * period) : UNKNOWN_PERIOD.fresh;
  const stale = period > 0 ? Math.max(MIN_STALE, 12 * period) : UNKNOWN_PERIOD.stale;
  if (age > stale) return NONE;
  if (age > fresh) return { kind: "stale", value: latest.value, age };
  return { kind: "fresh", value: latest.value };
}

/** Seconds between two values of this name by the plan in force. */
function period(name: string): number {
  const state = live.state;
  if (!state || state.rate <= 0) return 0;
  const every = state.plan.wanted.find((wanted) => wanted.name === name)?.every ?? 1;
  return every / state.rate;
}

/** Read `frameClock.fast` beside it. */
export function currentValue(name: string): DisplayValue {
  const source = display.source;
  const latest = source.latest(name);
  if (source.kind === "recording") return isInGap(latest, source.now()) ? NONE : displayValueOf(latest, source.now(), 0);
  if (live.link !== "open" || live.state?.line !== "sampling") return NONE;
  if (isInGap(latest, source.now())) return NONE;
  return displayValueOf(latest, source.now(), period(name));
}

/** Within a gap that began after this value. */
function isInGap(latest: Latest | undefined, now: number): boolean {
  if (!latest) return true;
  const events = display.source.events;
  for (let at = events.length - 1; at >= 0; at -= 1) {
    const event = events[at]!;
    if (event.kind !== "gap" || event.began > now) continue;
    return event.began >= latest.time && (event.ended === null || event.ended > now);
  }
  return false;
}
