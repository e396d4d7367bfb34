// Rows of tiles: each row fills the width, so that no tile is left alone in the last one. While editing the rows are the same.
import type { Tile } from "../../lib/api/types";

export interface Placed {
  /** Columns of the tile, and of its row. */
  span: number;
  columns: number;
}

/** Pixels between tiles. */
export const GAP = 10;

/** A row of tiles of different heights looks ragged; this is what it costs, in squares of missing columns. */
const MIXED = 5;
const ROW = 0.5;

/** Place tiles in their order into rows of at most `most` columns, as even as possible. */
export function rowsOf(tiles: readonly Pick<Tile, "kind" | "span">[], most: number): Placed[] {
  const whole = tiles.map((tile) => tile.span === 3 || tile.kind === "table" || tile.kind === "strip");
  const spans = tiles.map((tile, at) => (whole[at] ? most : Math.min(tile.span, most)));
  // The cheapest way to place the first n tiles, and where its last row begins.
  const cost = [0];
  const begins = [0];
  for (let end = 1; end <= tiles.length; end += 1) {
    cost[end] = Infinity;
    let used = 0;
    let gauges = 0;
    for (let begin = end - 1; begin >= 0; begin -= 1) {
      used += spans[begin]!;
      if (used > most) break;
      // A tile that fills a row stands alone.
      if (begin < end - 1 && (whole[begin] || whole[end - 1])) break;
      if (tiles[begin]!.kind === "gauge") gauges += 1;
      const mixed = gauges > 0 && gauges < end - begin ? MIXED : 0;
      const sum = cost[begin]! + (most - used) ** 2 + mixed + ROW;
      if (sum < cost[end]!) {
        cost[end] = sum;
        begins[end] = begin;
      }
    }
  }
  const placed: Placed[] = [];
  for (let end = tiles.length; end > 0; end = begins[end]!) {
    const row = spans.slice(begins[end], end);
    const columns = row.reduce((sum, span) => sum + span, 0);
    placed.unshift(...row.map((span) => ({ span, columns })));
  }
  return placed;
}
