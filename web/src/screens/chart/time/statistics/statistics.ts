// Statistics of one channel over a span. Weighted by time: a value counts until the next one of its channel, the last one until the end of
// the span, so that a change of the sampling rate does not move the mean. A pause longer than `gap` counts for nothing.

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
export function statistics(
  times: ArrayLike<number>,
  column: ArrayLike<number>,
  from: number,
  to: number,
  gap: number,
): Statistics | null {
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

const standing = (seconds: number, gap: number) => (seconds <= gap ? Math.max(0, seconds) : 0);

function sum(numbers: readonly number[]): number {
  let total = 0;
  for (const number of numbers) total += number;
  return total;
}

/** Rows as text with tabs, for a spreadsheet. */
export const tabbed = (rows: readonly (readonly (string | number)[])[]): string =>
  rows.map((row) => row.map((cell) => String(cell).replace(/[\t\r\n]+/g, " ")).join("\t")).join("\n") + "\n";
