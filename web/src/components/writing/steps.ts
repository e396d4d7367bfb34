// Values that the bytes of a parameter can hold: from `lowest` on in steps.
import type { WritableParameter } from "../../lib/api/types";

const MOST_DIGITS = 6;

/** Digits after the point that distinguish neighbouring values. */
export function digitsOf(step: number): number {
  for (let digits = 0; digits <= MOST_DIGITS; digits++) {
    const scaled = step * 10 ** digits;
    if (Math.abs(scaled - Math.round(scaled)) < 1e-9 * scaled) return digits;
  }
  return Math.min(MOST_DIGITS, Math.ceil(-Math.log10(step)) + 1);
}

/** The value that is `count` steps from `value`, at most at the ends. */
export function moved(value: number, count: number, { lowest, highest, step }: WritableParameter): number {
  if (lowest === null || highest === null || step === null) return value;
  const at = Math.round((value - lowest) / step) + count;
  const last = Math.round((highest - lowest) / step);
  return lowest + Math.max(0, Math.min(last, at)) * step;
}

/** Whether the nearest value of the bytes is one that they can hold. */
export function fits(value: number, { lowest, highest, step }: WritableParameter): boolean {
  if (lowest === null || highest === null || step === null) return false;
  return value >= lowest - step / 2 && value < highest + step / 2;
}
