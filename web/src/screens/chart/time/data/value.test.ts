import { describe, expect, it } from "vitest";
import { Columns } from "../../../../lib/series/columns";
import type { LineEvent } from "../../../../lib/api/types";
import { gapThreshold } from "../../../../lib/series/gapThreshold";
import { randoms } from "../../../../../test/random";
import { rowsBetween, statistics } from "../statistics/statistics";
import { meanOf, valueAt } from "./value";

const columns = new Columns();
columns.append(["A"], [10, 11, 12, 15, 16], [[1, 2, 3, 4, 5]]);
const gap: LineEvent = { kind: "gap", time: 12.2, began: 12.2, ended: 14.9, reason: { en: "x", ru: "х" } };

describe("valueAt", () => {
  it("returns the last recent value", () => {
    expect(valueAt(columns, [], "A", 11.5)).toBe(2);
    expect(valueAt(columns, [], "A", 20.9)).toBe(5);
    expect(valueAt(columns, [], "A", 21.1)).toBeNull();
    expect(valueAt(columns, [], "A", 9)).toBeNull();
    expect(valueAt(columns, [], "B", 11)).toBeNull();
  });

  it("is null in a gap of any length", () => {
    expect([12.1, 12.3, 14.8, 15].map((time) => valueAt(columns, [gap], "A", time))).toEqual([3, null, null, 4]);
    expect(valueAt(columns, [{ ...gap, ended: null } as LineEvent], "A", 14)).toBeNull();
  });

  it("works with decimated rows", () => {
    const thin = new Columns();
    thin.append(["A"], [0, 20, 40], [[1, 2, 3]]);
    thin.spacing = 40;
    expect(valueAt(thin, [], "A", 19)).toBe(1);
  });
});

describe("meanOf", () => {
  it("is the mean of the statistics, over random values with pauses", () => {
    const next = randoms(5);
    for (let turn = 0; turn < 50; turn += 1) {
      const data = new Columns();
      let time = 100;
      const times = Array.from({ length: 200 }, () => (time += next() < 0.03 ? 20 : 0.01 + next()));
      data.append(["A"], times, [times.map(() => (next() < 0.2 ? null : 100 * next()))]);
      const [from, to] = [times[Math.floor(50 * next())]!, times[100 + Math.floor(99 * next())]! + next()];
      const [first, last] = rowsBetween(data, from, to);
      const all = statistics(data.times(first, last), data.column("A", first, last)!, from, to, gapThreshold(data, "A", first, last))!;
      expect(meanOf(data, "A", from, to)).toBeCloseTo(all.mean, 9);
    }
  });

  it("weighs by time; one value is its own mean, none has none", () => {
    const data = new Columns();
    data.append(["A"], [0, 1, 1.5, 2, 2.5], [[10, 25, 25, 25, 25]]);
    expect(meanOf(data, "A", 0, 3)).toBeCloseTo(20, 9);
    expect(meanOf(data, "A", 1, 1)).toBe(25);
    expect([meanOf(data, "A", 4, 5), meanOf(data, "B", 0, 2)]).toEqual([null, null]);
  });
});
