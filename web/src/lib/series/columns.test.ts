import { describe, expect, it } from "vitest";
import { Columns } from "./columns";

const range = (from: number, to: number) => Array.from({ length: to - from }, (_, index) => from + index);

describe("Columns", () => {
  it("stores rows and returns views", () => {
    const columns = new Columns();
    columns.append(
      ["A", "B"],
      [1, 2, 3],
      [
        [10, null, 30],
        [true, false, null],
      ],
    );
    expect([...columns.times()]).toEqual([1, 2, 3]);
    expect([...columns.column("A")!]).toEqual([10, NaN, 30]);
    expect([...columns.column("B")!]).toEqual([1, 0, NaN]);
    expect(columns.column("C")).toBeUndefined();
    expect([columns.first, columns.last]).toEqual([1, 3]);
  });

  it("ignores a repeated message", () => {
    const columns = new Columns();
    expect(columns.append(["A"], [1, 2], [[1, 2]])).toBe(2);
    expect(columns.append(["A"], [1, 2, 3], [[1, 2, 3]])).toBe(1);
    expect(columns.append(["A"], [2], [[9]])).toBe(0);
    expect([...columns.column("A")!]).toEqual([1, 2, 3]);
  });

  it("has NaN for a channel before its first and after its last row", () => {
    const columns = new Columns();
    columns.append(["A"], [1, 2], [[1, 2]]);
    columns.append(["B"], [3], [[5]]);
    columns.append(["A"], [4], [[6]]);
    expect([...columns.column("A")!]).toEqual([1, 2, NaN, 6]);
    expect([...columns.column("B")!]).toEqual([NaN, NaN, 5, NaN]);
  });

  it("grows, then drops the oldest rows in order", () => {
    const columns = new Columns(10_000);
    let next = 0;
    for (const size of [1, 5000, 3000, 700, 4999, 1, 10_000, 3]) {
      const times = range(next, next + size);
      columns.append(["A"], times, [times.map((time) => time * 2)]);
      next += size;
      expect(columns.length).toBeLessThanOrEqual(10_000);
      expect(columns.last).toBe(next - 1);
      expect(columns.start + columns.length).toBe(next);
      expect([...columns.times()]).toEqual(range(columns.start, next));
      expect(columns.column("A")!.every((value, row) => value === columns.times()[row]! * 2)).toBe(true);
    }
  });

  it("keeps the last rows of an append beyond the capacity", () => {
    const columns = new Columns(5000);
    const times = range(0, 12_000);
    columns.append(["A"], times, [times]);
    expect(columns.last).toBe(11_999);
    expect(columns.length).toBeLessThanOrEqual(5000);
    expect([...columns.column("A")!]).toEqual([...columns.times()]);
  });

  it("drops rows older than its span", () => {
    const columns = new Columns(1 << 18, 1000);
    for (let time = 0; time < 50_000; time += 100) {
      const times = range(time, time + 100).map((at) => at / 10);
      columns.append(["A"], times, [times]);
    }
    expect(columns.last - columns.first).toBeGreaterThan(999);
    expect(columns.last - columns.first).toBeLessThan(1400);
  });

  it("finds rows by time and values by row", () => {
    const columns = new Columns();
    columns.append(["A"], [10, 20, 30], [[1, null, 3]]);
    expect([5, 10, 19, 20, 99].map((time) => columns.rowAt(time))).toEqual([-1, 0, 0, 1, 2]);
    expect([5, 10, 19, 20, 99].map((time) => columns.rowFrom(time))).toEqual([0, 0, 1, 1, 3]);
    expect(columns.valueAt("A", 1)).toEqual({ value: 1, row: 0 });
    expect(columns.valueAt("A", 1, 5)).toBeUndefined();
    expect(columns.valueAt("A", 2)).toEqual({ value: 3, row: 2 });
    expect(columns.valueAt("A", -1)).toBeUndefined();
    expect(columns.valueAt("B", 2)).toBeUndefined();
  });

  it("clears", () => {
    const columns = new Columns();
    columns.append(["A"], [1, 2], [[1, 2]]);
    columns.clear();
    expect(columns.length).toBe(0);
    columns.append(["A"], [1], [[7]]);
    expect([...columns.column("A")!]).toEqual([7]);
  });
});
