import { describe, expect, it } from "vitest";
import type { Channel } from "../api/types";
import { Columns } from "../series/columns";
import { binOf, defaultEdges, fittedEdges, multiples, roundValues, stepped, typedEdges } from "./bins";
import { Cells, STATISTICS } from "./cells";
import { Pairs } from "./pairs";
import { stretchesOf } from "./stretches";
import { randoms } from "../../../test/random";

function pairsOf(rows: readonly (readonly [number, number, number, number])[]): Pairs {
  const columns = new Columns();
  columns.append(
    ["Z", "X", "Y"],
    rows.map(([time]) => time),
    [1, 2, 3].map((at) => rows.map((row) => row[at]!)),
  );
  const pairs = new Pairs({
    name: "Z",
    partners: [
      { name: "X", needed: true },
      { name: "Y", needed: true },
    ],
    age: 0,
    span: null,
  });
  while (pairs.read(columns, [], 1000));
  return pairs;
}

describe("cells", () => {
  it("have the statistics of a naive sum over random values, read in portions", () => {
    const next = randoms(11);
    const rows = Array.from({ length: 4000 }, (_, at) => [at / 10, 1e6 + next(), 100 * next() - 10, 50 * next()] as const);
    const columns = [0, 10, 25, 60, 80];
    const edges = [0, 5, 30, 49];
    const pairs = pairsOf(rows);
    const cells = new Cells(columns, edges);
    while (cells.take(pairs, 137));
    let inside = 0;
    for (let x = 0; x + 1 < columns.length; x += 1) {
      for (let y = 0; y + 1 < edges.length; y += 1) {
        const within = (value: number, list: readonly number[], at: number) =>
          value >= list[at]! && (value < list[at + 1]! || (at + 2 === list.length && value === list[at + 1]));
        const values = rows.filter((row) => within(row[2], columns, x) && within(row[3], edges, y)).map((row) => row[1]);
        const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
        const deviation = Math.sqrt(values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / (values.length - 1));
        const expected = { mean, count: values.length, min: Math.min(...values), max: Math.max(...values), deviation };
        const cell = y * cells.width + x;
        for (const statistic of STATISTICS) expect(cells.value(cell, statistic, 1)).toBeCloseTo(expected[statistic], 6);
        expect(cells.pairsIn(cell, pairs)).toHaveLength(values.length);
        inside += values.length;
      }
    }
    expect(cells.outside).toBe(rows.length - inside);
    expect(cells.outside).toBeGreaterThan(100);
  });

  it("have no value below the least count, and no deviation of one value", () => {
    const cells = new Cells([0, 1, 2], [0, 1]);
    const pairs = pairsOf([
      [0, 5, 0.5, 0.5],
      [1, 6, 1.5, 0.5],
      [2, 8, 1.5, 0.5],
    ]);
    cells.take(pairs, 10);
    expect([0, 1].map((cell) => cells.value(cell, "mean", 2))).toEqual([NaN, 7]);
    expect([0, 1].map((cell) => cells.value(cell, "count", 2))).toEqual([1, 2]);
    expect(cells.value(0, "deviation", 1)).toBeNaN();
    expect(cells.value(1, "deviation", 1)).toBeCloseTo(Math.SQRT2);
  });
});

describe("bins", () => {
  it("hold their lower edge, the last one also its upper edge", () => {
    const edges = [0, 500, 1000, 3000];
    expect([-1, 0, 499.9, 500, 999, 1000, 3000, 3000.1, NaN].map((value) => binOf(edges, value))).toEqual([-1, 0, 0, 1, 1, 2, 2, -1, -1]);
  });

  it("have round edges that cover a range", () => {
    const channel = (given: Partial<Channel>) => ({ flag: false, gauge: null, range: null, decimals: 0, ...given }) as Channel;
    expect(defaultEdges(channel({ gauge: [0, 400] }), undefined)).toEqual([
      0, 25, 50, 75, 100, 125, 150, 175, 200, 225, 250, 275, 300, 325, 350, 375, 400,
    ]);
    expect(defaultEdges(channel({ gauge: [0.7, 1.3] }), undefined)).toEqual([
      0.7, 0.75, 0.8, 0.85, 0.9, 0.95, 1, 1.05, 1.1, 1.15, 1.2, 1.25, 1.3,
    ]);
    expect(defaultEdges(channel({ flag: true }), undefined)).toEqual([-0.5, 0.5, 1.5]);
    expect(fittedEdges(channel({}), { min: 870, max: 870 })).toEqual([870, 871]);
    expect(fittedEdges(channel({ decimals: 1 }), { min: 12.3, max: 14.1 })).toEqual([
      12.2, 12.4, 12.6, 12.8, 13, 13.2, 13.4, 13.6, 13.8, 14, 14.2,
    ]);
    expect(fittedEdges(channel({}), { min: 840, max: 880 })).toEqual([
      840, 842.5, 845, 847.5, 850, 852.5, 855, 857.5, 860, 862.5, 865, 867.5, 870, 872.5, 875, 877.5, 880,
    ]);
    expect(multiples(-7, 12, 5)).toEqual([-10, -5, 0, 5, 10, 15]);
  });

  it("are typed, or given by a step", () => {
    expect(typedEdges(" 600 900;1200,5 ")).toEqual([600, 900, 1200.5]);
    expect(
      ["600", "600 500", "600 600", "a b", "", "1 Infinity", Array.from({ length: 40 }, (_, at) => at).join(" ")].map(typedEdges),
    ).toEqual(new Array(7).fill(null));
    expect(stepped(600, 0.1, 600.3)).toEqual([600, 600.1, 600.2, 600.3]);
    expect([stepped(0, 0, 5), stepped(0, -1, 5), stepped(5, 1, 5), stepped(0, 1, 33), stepped(0, NaN, 5)]).toEqual([
      null,
      null,
      null,
      null,
      null,
    ]);
    expect(stepped(0, 2, 5)).toEqual([0, 2, 4, 6]);
  });
});

describe("stretches", () => {
  it("join neighbours without another pair or a pause between them", () => {
    const rows = [0, 0.1, 0.2, 0.3, 0.4, 5, 5.1, 5.2].map((time) => [time, 0, 0, 0] as const);
    expect(stretchesOf(pairsOf(rows), [1, 2, 4, 5, 7])).toEqual([
      { from: 0.1, to: 0.2 },
      { from: 0.4, to: 0.4 },
      { from: 5, to: 5 },
      { from: 5.2, to: 5.2 },
    ]);
  });
});

it("an axis has round values inside its range", () => {
  expect(roundValues(0.3, 10.2, 5)).toEqual([2, 4, 6, 8, 10]);
  expect(roundValues(-0.05, 0.05, 4)).toEqual([-0.05, -0.025, 0, 0.025, 0.05]);
  expect([roundValues(5, 5, 6), roundValues(0, Infinity, 6)]).toEqual([[], []]);
});
