// The map of a dump's blocks as cells of a grid, its progress, and the estimated time.

import type { Dump } from "../../../lib/api/types";
import type { SpaceName } from "../cells/hex";

export type Block = Dump["blocks"][number];
export type BlockState = Block["state"];

export interface MapCell extends Block {
  column: number;
  row: number;
}

export interface BlockMap {
  columns: number;
  rows: number;
  cells: MapCell[];
  counts: Record<BlockState, number>;
}

export function mapOf(blocks: readonly Block[], columns = 32): BlockMap {
  const counts: Record<BlockState, number> = { todo: 0, done: 0, retried: 0, failed: 0 };
  const across = Math.max(1, Math.min(columns, blocks.length));
  const cells = blocks.map((block, at) => {
    counts[block.state]++;
    return { ...block, column: at % across, row: Math.floor(at / across) };
  });
  return { columns: across, rows: Math.max(1, Math.ceil(cells.length / across)), cells, counts };
}

/** Which pass is running and its progress: a dump that is verified reads twice its size. */
export function passOf(dump: Pick<Dump, "first" | "last" | "done" | "total">): {
  done: number;
  size: number;
  pass: number;
  passes: number;
} {
  const size = dump.last - dump.first + 1;
  const passes = Math.max(1, Math.round(dump.total / size));
  const pass = Math.min(passes, Math.floor(dump.done / size) + 1);
  return { done: dump.done - (pass - 1) * size, size, pass, passes };
}

/** A whole number 0 … 100; 100 only when complete. */
export function percent(done: number, total: number): number {
  if (total <= 0) return 0;
  if (done >= total) return 100;
  return Math.min(99, Math.floor((done / total) * 100));
}

/**
 * Seconds to read `count` bytes at best (§5): 960 bytes a second, 10 bytes of framing and 2 ms of response time a block; byte by byte
 * (SFR) 4 + 4 bytes each.
 */
export function secondsFor(space: SpaceName, count: number, block: number): number {
  const rate = 960;
  if (space === "sfr") return count * (8 / rate + 0.002);
  const requests = Math.ceil(count / Math.max(1, block));
  return requests * (10 / rate + 0.002) + (count * (1 + 2 / 256)) / rate;
}
