// Whether a value is current. Its period is known from the plan and the rate: fresh for four periods, then stale and shown with its age;
// after twelve periods, in a gap or without a connection there is no value, and a dash is shown. Transmission may add half a second.
import type { LineEvent } from "../api/types";
import type { Latest } from "../live/live.svelte";

export type DisplayValue = { kind: "fresh"; value: number } | { kind: "stale"; value: number; age: number } | { kind: "none" };

export const NONE: DisplayValue = { kind: "none" };

/** Seconds: lower bounds for fresh and stale, because messages and the ECU's responses vary. */
const MIN_FRESH = 0.5;
const MIN_STALE = 3;
/** Seconds, when the period is unknown: in a recording, and before a rate is known. */
const UNKNOWN_PERIOD = { fresh: 1, stale: 10 };

/** Classify a value by its age and its period; period 0: unknown. */
export function displayValueOf(latest: Latest | undefined, now: number, period: number): DisplayValue {
  if (!latest) return NONE;
  const age = now - latest.time;
  const fresh = period > 0 ? Math.max(MIN_FRESH, 4 * period) : UNKNOWN_PERIOD.fresh;
  const stale = period > 0 ? Math.max(MIN_STALE, 12 * period) : UNKNOWN_PERIOD.stale;
  if (age > stale) return NONE;
  if (age > fresh) return { kind: "stale", value: latest.value, age };
  return { kind: "fresh", value: latest.value };
}

/** Whether a gap that began after this value is still open at `now`. */
export function isInGap(events: readonly LineEvent[], latest: Latest | undefined, now: number): boolean {
  if (!latest) return true;
  for (let at = events.length - 1; at >= 0; at -= 1) {
    const event = events[at]!;
    if (event.kind !== "gap" || event.began > now) continue;
    return event.began >= latest.time && (event.ended === null || event.ended > now);
  }
  return false;
}
