import { describe, expect, it } from "vitest";
import { Cells } from "../../../lib/pairs/cells";
import { Pairs } from "../../../lib/pairs/pairs";
import { Columns } from "../../../lib/series/columns";
import { countOf, rangeOf, usedPart, valueOf } from "./shown";

function cellsOf(values: readonly [number, number][]): Cells {
  const columns = new Columns();
  columns.append(
    ["Z", "X"],
    values.map((_, at) => at),
    [values.map(([z]) => z), values.map(([, x]) => x)],
  );
  const pairs = new Pairs({
    name: "Z",
    partners: [
      { name: "X", needed: true },
      { name: "X", needed: true },
    ],
    age: 0,
    span: null,
  });
  pairs.read(columns, [], 100);
  const cells = new Cells([0, 1, 2], [0, 2]);
  cells.take(pairs, 100);
  return cells;
}

describe("a table", () => {
  const first = cellsOf([
    [10, 0.5],
    [20, 0.5],
    [7, 1.5],
  ]);
  const second = cellsOf([
    [11, 0.5],
    [12, 0.5],
    [13, 0.5],
  ]);

  it("shows one recording, the other or the difference; none where one has too few readings", () => {
    const all = (side: "first" | "second" | "difference") => [0, 1].map((cell) => valueOf(cell, first, second, side, "mean", 1));
    expect([all("first"), all("second"), all("difference")]).toEqual([
      [15, 7],
      [12, NaN],
      [3, NaN],
    ]);
    expect(valueOf(0, first, second, "difference", "mean", 3)).toBeNaN();
    expect((["first", "second", "difference"] as const).map((side) => countOf(0, first, second, side))).toEqual([2, 3, 2]);
  });

  it("is coloured from its lowest to its highest value, a difference evenly around 0", () => {
    expect([rangeOf([3, NaN, -1], "first"), rangeOf([3, NaN, -1], "difference"), rangeOf([NaN], "first")]).toEqual([
      [-1, 3],
      [-3, 3],
      null,
    ]);
  });

  it("leaves out the empty rows and columns around, not those between", () => {
    expect(usedPart([0, 0, 0, 0, 0, 5, 0, 0, 0, 2, 0, 0, 0, 0, 0], 5)).toEqual({ left: 0, right: 5, bottom: 1, top: 2 });
    expect(usedPart([0, 1, 0, 0], 2)).toEqual({ left: 1, right: 2, bottom: 0, top: 1 });
    expect(usedPart([0, 0], 2)).toBeNull();
  });
});
