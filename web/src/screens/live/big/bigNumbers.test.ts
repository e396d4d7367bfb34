import { expect, it } from "vitest";
import type { Tile } from "../../../lib/api/types";
import { bigRows, storedNames, usualNames } from "./bigNumbers";

const channels = ["TWAT", "FREQ", "UACC"].map((name) => ({ name }));
const tile = (kind: Tile["kind"], ...names: string[]): Tile => ({ kind, names, span: 1 });

it("the usual values are the first gauges, then numbers; of a table, those that matter most", () => {
  expect(usualNames({ tiles: [tile("number", "A"), tile("gauge", "B"), tile("strip", "B", "C")] }, channels)).toEqual(["B", "A", "C"]);
  expect(usualNames({ tiles: "ABCDE".split("").map((name) => tile("gauge", name)) }, channels)).toHaveLength(4);
  expect(usualNames({ tiles: [tile("table")] }, channels)).toEqual(["FREQ", "TWAT", "UACC"]);
});

it("stored values are taken if they exist, six at most", () => {
  expect(storedNames('["UACC", "GONE", "UACC", 3]', channels)).toEqual(["UACC"]);
  for (const bad of [null, "", "{", "[]", '"FREQ"', '["GONE"]']) expect(storedNames(bad, channels)).toBeNull();
  const many = Array.from({ length: 9 }, (_, at) => ({ name: `N${at}` }));
  expect(storedNames(JSON.stringify(many.map(({ name }) => name)), many)).toHaveLength(6);
});

it("cells share a wide and a narrow screen, every row full", () => {
  expect(bigRows([2, 2, 2, 2], 1366, 768)).toEqual([2, 2]);
  expect(bigRows([2, 2, 2, 2], 390, 844)).toEqual([1, 1, 1, 1]);
  expect(bigRows([2], 1366, 768)).toEqual([1]);
  expect(bigRows([2, 2, 2, 2, 2], 1366, 768)).toEqual([3, 2]);
  for (let count = 1; count <= 6; count += 1) {
    const rows = bigRows(
      Array.from({ length: count }, () => 2.5),
      844,
      390,
    );
    expect(rows.reduce((sum, cells) => sum + cells, 0)).toBe(count);
  }
});
