// Big numbers: which values, and how they share the screen.
import type { Channel, Preset, Tile } from "../../../lib/api/types";

export const MOST = 6;
const USUAL = 4;
/** For a preset without gauges and numbers: a table of everything. */
const FIRST = ["FREQ", "TWAT", "UACC", "JAIR"];

/** The values shown until others are chosen: the first gauges of the preset, then its numbers. */
export function usualNames(preset: Pick<Preset, "tiles">, channels: readonly Pick<Channel, "name">[]): string[] {
  const of = (kind: Tile["kind"]) => preset.tiles.filter((tile) => tile.kind === kind).flatMap(({ names }) => names);
  const names = [...new Set([...of("gauge"), ...of("number"), ...of("lamp"), ...of("strip"), ...of("table")])];
  if (names.length > 0) return names.slice(0, USUAL);
  const known = channels.map(({ name }) => name);
  const first = FIRST.filter((name) => known.includes(name));
  return first.length > 0 ? first : known.slice(0, USUAL);
}

/** The names stored as JSON, if they can be shown; else null. */
export function storedNames(text: string | null, channels: readonly Pick<Channel, "name">[]): string[] | null {
  try {
    const stored: unknown = JSON.parse(text ?? "null");
    if (!Array.isArray(stored)) return null;
    const isChannel = (name: unknown): name is string => channels.some((channel) => channel.name === name);
    const names = [...new Set<unknown>(stored)].filter(isChannel);
    return names.length > 0 ? names.slice(0, MOST) : null;
  } catch {
    return null;
  }
}

/** Pixels of a cell: its name with the gap between rows, and its margins. */
const HEAD = 60;
const SIDES = 40;

/**
 * Rows of cells with the largest digits: `widths` are the values' widths in em. Returns the number of cells in each row; rows differ by one
 * cell at most, and each fills the width.
 */
export function bigRows(widths: readonly number[], width: number, height: number): number[] {
  let best: number[] = [widths.length];
  let largest = -Infinity;
  for (let count = 1; count <= widths.length; count += 1) {
    const rows = Array.from({ length: count }, (_, row) => Math.floor((widths.length + count - 1 - row) / count));
    let at = 0;
    let size = height / count - HEAD;
    for (const cells of rows) {
      const widest = Math.max(...widths.slice(at, at + cells));
      size = Math.min(size, (width / cells - SIDES) / widest);
      at += cells;
    }
    if (size > largest) {
      largest = size;
      best = rows;
    }
  }
  return best;
}
