import { describe, expect, it } from "vitest";
import { Columns } from "./columns";
import { decimate, findHoles } from "./decimate";

function filled(rows: number, value: (row: number) => number | null, step = 0.01): Columns {
  const columns = new Columns(1 << 17);
  const times = Array.from({ length: rows }, (_, row) => 1000 + row * step);
  columns.append(["A"], times, [times.map((_, row) => value(row))]);
  return columns;
}

describe("decimate", () => {
  it("returns all rows where there is room, with one more on each side", () => {
    const columns = filled(100, (row) => row);
    const { times, values, width } = decimate(columns, ["A"], 1000.195, 1000.305, 50);
    expect(width).toBe(0);
    expect(values[0]).toEqual([19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31]);
    expect(times).toHaveLength(13);
  });

  it("keeps a spike of one row in a hundred thousand, up and down", () => {
    const columns = filled(100_000, (row) => (row === 54_321 ? 900 : row === 70_007 ? -5 : 1));
    const { values, times } = decimate(columns, ["A"], 1000, 2000, 500);
    expect(times.length).toBeLessThanOrEqual(2 * 502);
    expect(values[0]).toContain(900);
    expect(values[0]).toContain(-5);
  });

  it("draws only the ends of a flat stretch, and enough rows at the edges for the scale", () => {
    const columns = filled(60, (row) => (row < 20 ? 1 : row < 40 ? 2 : 1));
    const drawn = decimate(columns, ["A"], 1000, 1000.6, 100).values[0]!;
    expect(drawn.flatMap((value, row) => (value === undefined ? [] : [[row, value]]))).toEqual([
      ...[0, 1, 2, 3].map((row) => [row, 1]),
      [19, 1],
      [20, 2],
      [39, 2],
      [40, 1],
      ...[56, 57, 58, 59].map((row) => [row, 1]),
    ]);
  });

  it("keeps values between missing ones", () => {
    const columns = filled(30, (row) => (row % 3 === 0 ? 7 : null));
    const drawn = decimate(columns, ["A"], 1000, 1000.3, 100).values[0]!;
    expect(drawn.filter((value) => value === 7)).toHaveLength(10);
  });

  it("keeps the order of minimum and maximum", () => {
    const rising = decimate(
      filled(1000, (row) => row),
      ["A"],
      1000,
      1010,
      10,
    );
    const falling = decimate(
      filled(1000, (row) => -row),
      ["A"],
      1000,
      1010,
      10,
    );
    expect(rising.values[0]).toEqual([...(rising.values[0] as number[])].sort((a, b) => a - b));
    expect(falling.values[0]).toEqual([...(falling.values[0] as number[])].sort((a, b) => b - a));
  });

  it("does not change past points when the window moves", () => {
    const columns = filled(10_000, (row) => Math.sin(row * 1.7) * row);
    const one = decimate(columns, ["A"], 1000, 1090, 300);
    const other = decimate(columns, ["A"], 1002.37, 1092.37, 300);
    const before = new Map(one.times.map((time, index) => [time.toFixed(6), one.values[0]![index]]));
    const inside = other.times
      .map((time, index) => [time.toFixed(6), other.values[0]![index], time] as const)
      .filter(([, , time]) => time > 1003 && time < 1089.5);
    expect(inside.length).toBeGreaterThan(500);
    for (const [key, value] of inside) expect(before.get(key)).toBe(value);
  });

  it("has null for buckets without a value and for unknown names", () => {
    const columns = filled(10_000, (row) => (row >= 4000 && row < 6000 ? null : 7));
    const { values, times } = decimate(columns, ["A", "B"], 1000, 1100, 100);
    const middle = times.findIndex((time) => time > 1050);
    expect(values[0]![middle]).toBeNull();
    expect(values[0]![0]).toBe(7);
    expect(values[1]!.every((value) => value === null)).toBe(true);
    expect(values[1]).toHaveLength(times.length);
  });

  it("accepts empty columns and an empty window", () => {
    expect(decimate(new Columns(), ["A"], 0, 10, 100)).toEqual({ times: [], values: [[]], width: 0 });
    expect(
      decimate(
        filled(100, () => 1),
        ["A"],
        5000,
        6000,
        10,
      ).times.length,
    ).toBeLessThanOrEqual(2);
  });
});

describe("findHoles", () => {
  it("returns the stretches longer than the threshold without a value", () => {
    expect(findHoles([0, 1, 2, 9, 10, 20], [1, null, 1, 1, 1, 1], 5)).toEqual([
      [2, 9],
      [10, 20],
    ]);
    expect(findHoles([0, 1], [null, null], 1)).toEqual([]);
  });
});
