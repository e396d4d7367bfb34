// The player's slider: positions and times, keys, speeds.

import { clock, point } from "../../../lib/i18n";
import { SPEEDS } from "../../../lib/recording/player.svelte";

export function faster(speed: number): number {
  return SPEEDS.find((it) => it > speed) ?? SPEEDS[SPEEDS.length - 1]!;
}

export function slower(speed: number): number {
  return [...SPEEDS].reverse().find((it) => it < speed) ?? SPEEDS[0];
}

/** Position on the slider, 0 … 1. */
export function share(time: number, first: number, last: number): number {
  if (last <= first) return 0;
  return Math.min(1, Math.max(0, (time - first) / (last - first)));
}

const STEPS: Readonly<Record<string, number>> = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 };
const LEAPS: Readonly<Record<string, number>> = { PageDown: -30, PageUp: 30, Home: -Infinity, End: Infinity };

/** Seconds for a key on the slider; an arrow moves by one, with Shift by ten; null: another key. */
export function keyStep(key: string, shift: boolean): number | null {
  const step = STEPS[key];
  if (step !== undefined) return shift ? 10 * step : step;
  return LEAPS[key] ?? null;
}

/** Format 65.25 as `1:05.3`, with two decimals `1:05.25`: samples can be hundredths apart. */
export function precise(seconds: number, decimals: 1 | 2 = 1): string {
  const parts = 10 ** decimals;
  const whole = Math.max(0, Math.round(seconds * parts));
  return `${clock(Math.floor(whole / parts))}${point()}${String(whole % parts).padStart(decimals, "0")}`;
}
