import { describe, expect, it } from "vitest";
import type { Channel } from "../../../../lib/api/types";
import { Columns } from "../../../../lib/series/columns";
import { bounds, rowsBetween, statistics } from "./statistics";

/** By counting milliseconds: the reference. */
function counted(times: number[], column: number[], from: number, to: number, gap: number) {
  const points = times
    .map((time, at) => ({ time, value: column[at]! }))
    .filter(({ time, value }) => !Number.isNaN(value) && time >= from && time <= to);
  const all: number[] = [];
  points.forEach(({ time, value }, at) => {
    const until = points[at + 1]?.time ?? to;
    if (until - time <= gap) for (let ms = 0; ms < Math.round((until - time) * 1000); ms += 1) all.push(value);
  });
  all.sort((one, other) => one - other);
  const mean = all.reduce((a, b) => a + b, 0) / all.length;
  const rank = (share: number) => all[Math.max(0, Math.ceil(share * all.length - 1e-9) - 1)]!;
  return {
    count: points.length,
    covered: all.length / 1000,
    mean,
    deviation: Math.sqrt(all.reduce((a, b) => a + (b - mean) ** 2, 0) / all.length),
    quantiles: [rank(0.05), rank(0.5), rank(0.95)],
    above: all.filter((value) => value > 20).length / 1000,
    below: all.filter((value) => value < 20).length / 1000,
  };
}

describe("statistics", () => {
  it("equals counting every millisecond", () => {
    let seed = 7;
    const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
    for (let round = 0; round < 60; round += 1) {
      const times: number[] = [];
      let now = 0;
      for (let row = 0; row < 30; row += 1) times.push((now += random() < 0.1 ? 5 : Math.ceil(random() * 300) / 1000));
      const column = times.map(() => (random() < 0.2 ? NaN : Math.round(random() * 40)));
      const [from, to] = [now * 0.1, now * 0.9].map((time) => Math.round(time * 1000) / 1000) as [number, number];
      const expected = counted(times, column, from, to, 2);
      const found = statistics(times, column, from, to, 2);
      if (expected.count === 0 || expected.covered === 0) continue;
      expect(found!.count).toBe(expected.count);
      expect(found!.covered).toBeCloseTo(expected.covered, 6);
      expect(found!.mean).toBeCloseTo(expected.mean, 6);
      expect(found!.deviation).toBeCloseTo(expected.deviation, 6);
      expect([found!.p5, found!.p50, found!.p95]).toEqual(expected.quantiles);
      expect(found!.above(20)).toBeCloseTo(expected.above, 6);
      expect(found!.below(20)).toBeCloseTo(expected.below, 6);
    }
  });

  it("weighs by time, not by samples", () => {
    const found = statistics([0, 1, 1.1, 1.2, 1.3], [10, 20, 20, 20, 20], 0, 2, 5)!;
    expect(found.mean).toBeCloseTo(15, 9);
    expect([found.count, found.covered]).toEqual([5, 2]);
  });

  it("counts a gap for nothing, and a moment as itself", () => {
    const gap = statistics([0, 1, 11, 12], [5, 5, 9, 9], 0, 12, 2)!;
    expect([gap.covered, gap.mean, gap.max]).toEqual([2, 7, 9]);
    const moment = statistics([3], [8], 0, 3, 2)!;
    expect([moment.count, moment.covered, moment.mean, moment.p50]).toEqual([1, 0, 8, 8]);
    expect(statistics([0, 1], [NaN, NaN], 0, 1, 2)).toBe(null);
    expect(statistics([0, 1], [1, 2], 5, 6, 2)).toBe(null);
  });
});

it("names each limit once, also if an own one is the same", () => {
  const limits = { danger_low: null, warning_low: 60, warning_high: 100, danger_high: 100, hysteresis: 0 } as Channel["limits"];
  expect(bounds(limits, 100)).toEqual([
    { key: "below", limit: 60 },
    { key: "below", limit: 100 },
    { key: "above", limit: 100 },
  ]);
  expect(bounds(undefined, null)).toEqual([]);
});

it("takes the values at both ends of a span, also of a real clock", () => {
  const columns = new Columns();
  const begin = 1_790_000_000;
  columns.append(["A"], [begin, begin + 1, begin + 2, begin + 3], [[1, 2, 3, 4]]);
  expect(rowsBetween(columns, begin + 1, begin + 2)).toEqual([1, 3]);
  expect(rowsBetween(columns, begin + 0.5, begin + 2.5)).toEqual([1, 3]);
});
