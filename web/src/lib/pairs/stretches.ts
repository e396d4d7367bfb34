// Moments that follow each other without interruption, as one stretch of time.
import type { Pairs } from "./pairs";

export interface Stretch {
  from: number;
  to: number;
}

/** Pairs that are usual intervals apart belong together; a longer pause separates them. */
const INTERVALS = 3;
const LEAST = 0.5;
const SAMPLES = 200;

/** Join the pairs of these numbers (ascending) into stretches: neighbours without another pair or a pause between. */
export function stretchesOf(pairs: Pairs, numbers: readonly number[]): Stretch[] {
  const { times } = pairs;
  const pause = Math.max(LEAST, INTERVALS * usualInterval(pairs));
  const found: Stretch[] = [];
  let before = -2;
  for (const at of numbers) {
    const time = times[at]!;
    const last = found[found.length - 1];
    if (last && at === before + 1 && time - last.to <= pause) last.to = time;
    else found.push({ from: time, to: time });
    before = at;
  }
  return found;
}

/** The median of some intervals, seconds. */
function usualInterval({ times, length }: Pairs): number {
  const step = Math.max(1, Math.floor(length / SAMPLES));
  const found: number[] = [];
  for (let at = step; at < length; at += step) found.push(times[at]! - times[at - 1]!);
  found.sort((one, other) => one - other);
  return found[found.length >> 1] ?? 0;
}
