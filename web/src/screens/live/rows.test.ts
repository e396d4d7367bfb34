import { describe, expect, it } from "vitest";
import type { Tile } from "../../lib/api/types";
import { rowsOf } from "./rows";

type Part = Pick<Tile, "kind" | "span">;
const gauge = (span: 1 | 2 | 3 = 1): Part => ({ kind: "gauge", span });
const number = (): Part => ({ kind: "number", span: 1 });

/** Sums of spans, row by row; fails if a row is not full. */
function rows(tiles: Part[], most: number): number[] {
  const found: number[] = [];
  let left = 0;
  for (const { span, columns } of rowsOf(tiles, most)) {
    if (left === 0) {
      left = columns;
      found.push(columns);
    }
    left -= span;
    expect(left).toBeGreaterThanOrEqual(0);
  }
  expect(left).toBe(0);
  return found;
}

describe("rows of tiles", () => {
  it("are even instead of leaving a few tiles over", () => {
    const idle = [
      gauge(2),
      ...Array.from({ length: 5 }, () => gauge()),
      ...Array.from({ length: 9 }, number),
      { kind: "strip", span: 3 } as Part,
    ];
    expect(rows(idle, 7)).toEqual([7, 5, 4, 7]);
    expect(rows(idle, 9)).toEqual([7, 9, 9]);
    expect(rows(idle, 2)).toEqual([2, 2, 2, 1, 2, 2, 2, 2, 1, 2]);
    expect(rows(idle, 1)).toHaveLength(16);
  });

  it("of every width and any tiles are full, and no row has more columns than there are", () => {
    for (let most = 1; most < 12; most += 1) {
      for (let seed = 1; seed < 40; seed += 1) {
        const tiles = Array.from({ length: seed }, (_, at) =>
          (at * seed) % 3 ? number() : gauge((((at * 7 + seed) % 3) + 1) as 1 | 2 | 3),
        );
        expect(Math.max(...rows(tiles, most))).toBeLessThanOrEqual(most);
      }
    }
  });
});
