// A freeze frame as the page shows it: which channels first, and the line of one channel as a path.
import type { FreezeFrame, Rows } from "../../lib/api/types";

export interface Line {
  /** Of an SVG, in a box of 100 × 30. */
  path: string;
  low: number;
  high: number;
}

/** s without a value after which the line is interrupted. */
const LONGEST = 1.5;

/** Related channels first, in their order; then the others. */
export function ordered(values: FreezeFrame["values"], related: readonly string[]): FreezeFrame["values"] {
  const rank = (name: string) => (related.includes(name) ? related.indexOf(name) : related.length);
  return [...values].sort((a, b) => rank(a.name) - rank(b.name));
}

/** The line of a channel over the whole frame; null: fewer than two values. */
export function lineOf(rows: Rows, name: string, least = 0): Line | null {
  const column = rows.values[rows.names.indexOf(name)];
  const first = rows.times[0];
  const last = rows.times.at(-1);
  if (!column || first === undefined || last === undefined || last <= first) return null;
  const known = column.flatMap((value, row) => (value === null ? [] : [{ time: rows.times[row]!, value }]));
  if (known.length < 2) return null;
  const low = Math.min(...known.map(({ value }) => value));
  const high = Math.max(...known.map(({ value }) => value));
  const more = Math.max(0, (least || 1) - (high - low)) / 2;
  const [from, span] = [low - more, high - low + 2 * more];
  let before = -Infinity;
  const path = known.map(({ time, value }) => {
    const x = (((time - first) / (last - first)) * 100).toFixed(2);
    const y = (28 - ((value - from) / span) * 26).toFixed(2);
    const command = time - before > LONGEST ? "M" : "L";
    before = time;
    return `${command}${x} ${y}`;
  });
  return { path: path.join(""), low, high };
}

/** Where the moment lies in the frame, in hundredths: from the last reading without the fault to the first with it. */
export function momentIn(rows: Rows, frame: Pick<FreezeFrame, "without" | "seen">): [number, number] {
  const [first, last] = [rows.times[0] ?? 0, rows.times.at(-1) ?? 1];
  const at = (time: number) => Math.min(100, Math.max(0, ((time - first) / (last - first || 1)) * 100));
  return [at(frame.without), at(frame.seen)];
}
