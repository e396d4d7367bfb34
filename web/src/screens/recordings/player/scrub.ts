// The player's slider: positions and times, speeds, and the loop between two marks.

import { clock, point } from "../../../lib/i18n";
import { SPEEDS } from "../../../lib/recording/player.svelte";

export interface Loop {
  from: number;
  to: number;
}

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

/** The first press marks the start of the loop, the second its end, the third removes it. */
export function nextLoop(loop: Partial<Loop> | null, time: number): { loop: Partial<Loop> | null; whole: Loop | null } {
  if (loop?.from === undefined) return { loop: { from: time }, whole: null };
  if (loop.to === undefined) {
    if (time === loop.from) return { loop: null, whole: null };
    const whole = { from: Math.min(loop.from, time), to: Math.max(loop.from, time) };
    return { loop: whole, whole };
  }
  return { loop: null, whole: null };
}

/** Seconds for an arrow key on the slider: one, ten with Shift or Page keys; null: another key. */
export function keyStep(key: string, shift: boolean): number | "first" | "last" | null {
  switch (key) {
    case "ArrowLeft":
    case "ArrowDown":
      return shift ? -10 : -1;
    case "ArrowRight":
    case "ArrowUp":
      return shift ? 10 : 1;
    case "PageDown":
      return -30;
    case "PageUp":
      return 30;
    case "Home":
      return "first";
    case "End":
      return "last";
    default:
      return null;
  }
}

/** Format 65.25 as `1:05.3`, with two decimals `1:05.25`: samples can be hundredths apart. */
export function precise(seconds: number, decimals: 1 | 2 = 1): string {
  const parts = 10 ** decimals;
  const whole = Math.max(0, Math.round(seconds * parts));
  return `${clock(Math.floor(whole / parts))}${point()}${String(whole % parts).padStart(decimals, "0")}`;
}
