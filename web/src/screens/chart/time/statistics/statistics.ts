// Statistics of one channel over a span. Weighted by time: a value counts until the next one of its channel, the last one until the end of
// the span, so that a change of the sampling rate does not move the mean. A pause longer than `gap` counts for nothing.
import type { Channel } from "../../../../lib/api/types";
import type { Columns } from "../../../../lib/series/columns";

export interface Statistics {
  /** Values in the span. */
  count: number;
  /** Seconds that the values stand for: the span without gaps. */
  covered: number;
  min: number;
  max: number;
  mean: number;
  /** Standard deviation. */
  deviation: number;
  /** The least values that 5, 50 and 95 % of the time do not exceed. */
  p5: number;
  p50: number;
  p95: number;
  /** Seconds with a value above, and below, a limit. */
  above(limit: number): number;
  below(limit: number): number;
}

/** Null: the span has no value. `times` ascend and are as long as `column`; NaN is no value. */
export function statistics(times: ArrayLike<number>, column: ArrayLike<number>, from: number, to: number, gap: number): Statistics | null {
  const values: number[] = [];
  const weights: number[] = [];
  let last = NaN;
  for (let row = 0; row < times.length; row += 1) {
    const [time, value] = [times[row]!, column[row]!];
    if (Number.isNaN(value) || time < from) continue;
    if (time > to) break;
    if (values.length > 0) weights.push(standing(time - last, gap));
    values.push(value);
    last = time;
  }
  if (values.length === 0) return null;
  weights.push(standing(to - last, gap));
  const covered = sum(weights);
  // Values without a duration, as a single one at the end of the span, count alike.
  const shares = covered > 0 ? weights.map((weight) => weight / covered) : weights.map(() => 1 / weights.length);
  const mean = sum(values.map((value, at) => value * shares[at]!));
  const deviation = Math.sqrt(sum(values.map((value, at) => (value - mean) ** 2 * shares[at]!)));
  const order = [...values.keys()].sort((one, other) => values[one]! - values[other]!);
  const quantile = (share: number): number => {
    let upto = 0;
    for (const at of order) {
      upto += shares[at]!;
      if (upto >= share - 1e-12 && shares[at]! > 0) return values[at]!;
    }
    return values[order.at(-1)!]!;
  };
  const beyond = (is: (value: number) => boolean) => sum(weights.filter((_, at) => is(values[at]!)));
  return {
    count: values.length,
    covered,
    min: values[order[0]!]!,
    max: values[order.at(-1)!]!,
    mean,
    deviation,
    p5: quantile(0.05),
    p50: quantile(0.5),
    p95: quantile(0.95),
    above: (limit) => beyond((value) => value > limit),
    below: (limit) => beyond((value) => value < limit),
  };
}

/** The seconds for which a value stands, if the next one comes after so many. */
export const standing = (seconds: number, gap: number): number => (seconds <= gap ? Math.max(0, seconds) : 0);

/** The rows of a span with both ends: the first one, and the first one behind. */
export const rowsBetween = (columns: Columns, from: number, to: number): [number, number] => [columns.rowFrom(from), columns.rowAt(to) + 1];

function sum(numbers: readonly number[]): number {
  let total = 0;
  for (const number of numbers) total += number;
  return total;
}

/** Below and above what a channel is timed: its limits and an own one, each once. */
export function bounds(limits: Channel["limits"] | undefined, own: number | null | undefined): { key: "below" | "above"; limit: number }[] {
  const once = (key: "below" | "above", all: readonly (number | null | undefined)[]) =>
    [...new Set(all)].flatMap((limit) => (limit === null || limit === undefined ? [] : [{ key, limit }]));
  return [
    ...once("below", [limits?.danger_low, limits?.warning_low, own]),
    ...once("above", [limits?.warning_high, limits?.danger_high, own]),
  ];
}
