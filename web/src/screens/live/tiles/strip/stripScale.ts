// The axes of a strip's lines. They change seldom, since the whole strip is drawn again then: when a value leaves its axis, when the
// values need less than a third of it, or when lines would cover each other.
import { anyCovered, axesOf, leastSpan, type Axis, type Line } from "../../../../lib/series/valueAxis";

/** The axis of each line; `before`: the last answer, for the same lines. */
export function steadyAxes(lines: readonly Line[], before: readonly Axis[], height: number): readonly Axis[] {
  const fit = before.length === lines.length && fits(lines, before) && !anyCovered(lines, before, height);
  return fit ? before : axesOf(lines, height);
}

function fits(lines: readonly Line[], axes: readonly Axis[]): boolean {
  const needed = new Map<Axis, number>();
  for (const [index, { channel, seen }] of lines.entries()) {
    const axis = axes[index]!;
    if (!seen || channel?.flag) continue;
    if (seen.min < axis.low || seen.max > axis.high) return false;
    needed.set(axis, Math.max(needed.get(axis) ?? 0, seen.max - seen.min, leastSpan(channel)));
  }
  return [...needed].every(([{ low, high }, least]) => high - low <= 3 * least);
}
