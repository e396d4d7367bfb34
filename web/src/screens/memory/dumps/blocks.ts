/**
 * The map of a dump: its blocks as cells of a grid, and what is left, in words' raw material.
 * One press on the page never begins a second dump of the same bytes; that is the server's care.
 */

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

/** How far one reading of it has come, and which it is: what is read twice has twice the bytes to read, but no more to hold. */
export function passOf(dump: Pick<Dump, "first" | "last" | "done" | "total">): { done: number; size: number; pass: number; passes: number } {
  const size = dump.last - dump.first + 1;
  const passes = Math.max(1, Math.round(dump.total / size));
  const pass = Math.min(passes, Math.floor(dump.done / size) + 1);
  return { done: dump.done - (pass - 1) * size, size, pass, passes };
}

/** 0 … 100, whole; 100 only when everything is there. */
export function percent(done: number, total: number): number {
  if (total <= 0) return 0;
  if (done >= total) return 100;
  return Math.min(99, Math.floor((done / total) * 100));
}

/**
 * What a read of `count` bytes takes on the wire at best (§5): 960 bytes a second, 10 bytes of
 * framing a block, 2 ms of the unit's thinking; one by one (SFR) 4 + 4 bytes each.
 */
export function secondsFor(space: SpaceName, count: number, block: number): number {
  const rate = 960;
  if (space === "sfr") return count * (8 / rate + 0.002);
  const requests = Math.ceil(count / Math.max(1, block));
  return requests * (10 / rate + 0.002) + (count * (1 + 2 / 256)) / rate;
}
