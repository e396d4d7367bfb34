// The edges of a table's rows and columns. A bin holds the values from its lower edge to below its upper one; the last bin also its upper edge.
import type { Channel } from "../api/types";
import { parsedNumber } from "../i18n";
import { countWhile, type Extremes } from "../series/columns";

export const MOST_BINS = 32;
/** Bins that a default has about. */
const DEFAULT_BINS = 16;

/** The bin of a value among ascending edges; -1: outside. */
export function binOf(edges: readonly number[], value: number): number {
  const count = edges.length - 1;
  if (!(value >= edges[0]!) || !(value <= edges[count]!)) return -1;
  return (
    Math.min(
      count,
      countWhile(edges.length, (at) => edges[at]! <= value),
    ) - 1
  );
}

/** A step of 1, 2, 2.5 or 5 times a power of ten by which `extent` has at most `most` parts, or one more where the ends are not at steps. */
export function niceStep(extent: number, most: number): number {
  const least = extent / most;
  if (!(least > 0) || !Number.isFinite(least)) return 1;
  const power = 10 ** Math.floor(Math.log10(least));
  for (const factor of [1, 2, 2.5, 5]) if (factor * power >= least * 0.999999) return factor * power;
  return 10 * power;
}

/** Multiples of `step` that cover the range. Rounded, so that 3 · 0.1 is 0.3. */
export function multiples(low: number, high: number, step: number): number[] {
  const first = Math.floor(low / step + 1e-6);
  const last = Math.max(first + 1, Math.ceil(high / step - 1e-6));
  return Array.from({ length: last - first + 1 }, (_, index) => Number(((first + index) * step).toPrecision(12)));
}

/** Round values inside a range, for an axis: about `most`. */
export function roundValues(low: number, high: number, most: number): number[] {
  if (!(high > low) || !Number.isFinite(high - low)) return [];
  const step = niceStep(high - low, most);
  const room = step * 1e-9;
  return multiples(low, high, step).filter((value) => value >= low - room && value <= high + room);
}

/** Edges from `from` in steps of `step` to `to`; null unless these make 1 to `MOST_BINS` bins. */
export function stepped(from: number, step: number, to: number): number[] | null {
  const count = Math.ceil((to - from) / step - 1e-6);
  if (!(step > 0) || !(count >= 1) || count > MOST_BINS) return null;
  return Array.from({ length: count + 1 }, (_, index) => Number((from + index * step).toPrecision(12)));
}

/** Edges typed by a person, separated by spaces or semicolons; commas are decimal. Null unless these are 2 or more ascending numbers. */
export function typedEdges(text: string): number[] | null {
  const edges = text
    .split(/[\s;]+/)
    .filter(Boolean)
    .map((word) => parsedNumber(word) ?? NaN);
  if (edges.length < 2 || edges.length > MOST_BINS + 1) return null;
  if (edges.some((edge) => !Number.isFinite(edge))) return null;
  return edges.every((edge, index) => index === 0 || edge > edges[index - 1]!) ? edges : null;
}

/** The edges for a channel: of its gauge, else of its range; `extremes`: of the data, where the catalog has neither. */
export function defaultEdges(channel: Channel | undefined, extremes: Extremes | undefined): number[] {
  if (channel?.flag) return [-0.5, 0.5, 1.5];
  const [low, high] = channel?.gauge ?? channel?.range ?? (extremes ? [extremes.min, extremes.max] : [0, 100]);
  return multiples(low, high, niceStep(high - low, DEFAULT_BINS));
}

/** Edges that cover the data. */
export function fittedEdges(channel: Channel | undefined, extremes: Extremes): number[] {
  if (channel?.flag) return [-0.5, 0.5, 1.5];
  const least = 10 ** -(channel?.decimals ?? 3);
  const extent = Math.max(extremes.max - extremes.min, least);
  return multiples(extremes.min, extremes.max, Math.max(niceStep(extent, DEFAULT_BINS), least));
}
