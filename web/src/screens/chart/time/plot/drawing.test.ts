import { describe, expect, it } from "vitest";
import { Columns } from "../../../../lib/series/columns";
import { drawing } from "./drawing";

/** Rows a tenth of a second apart from `first` on; none from..to. */
function rows(first: number, count: number, none: [number, number] = [0, 0]): Columns {
  const columns = new Columns(1 << 18);
  const times = Array.from({ length: count }, (_, row) => first + row / 10).filter((time) => time < none[0] || time >= none[1]);
  columns.append(["A"], times, [times.map((_, row) => (row % 2 ? 10 : 0))]);
  return columns;
}

describe("drawing", () => {
  it("shifts the second recording by the lag, with its own gaps and rows", () => {
    const later = { columns: rows(5000, 100, [5002, 5006]), lag: -3999.95 };
    const { times, values, holes } = drawing(rows(1000, 100), later, ["A"], 1000, 1010, 300);
    expect(values).toHaveLength(2);
    expect(values[0]!.filter((value) => value !== undefined)).toHaveLength(100);
    expect(values[1]!.filter((value) => value !== undefined)).toHaveLength(60);
    expect(values[0]).toHaveLength(times.length);
    expect([...times].sort((one, other) => one - other)).toEqual(times);
    expect(holes[0]).toEqual([]);
    expect(holes[1]!.flat().map((time) => Number(time.toFixed(3)))).toEqual([1001.95, 1006.05]);
  });

  it("merges rows with the same time, and leaves missing channels empty", () => {
    const { times, values } = drawing(rows(1000, 10), { columns: rows(1000, 10), lag: 0 }, ["A", "B"], 1000, 1001, 300);
    expect(times).toHaveLength(10);
    expect(values.map((cells) => cells.filter((value) => value !== undefined).length)).toEqual([10, 0, 10, 0]);
  });

  it("keeps a spike of the second recording among a hundred thousand rows", () => {
    const columns = rows(0, 100_000);
    columns.append(["A"], [10_000], [[900]]);
    const { values, times } = drawing(rows(0, 100_000), { columns, lag: 1 }, ["A"], 0, 10_002, 400);
    expect(times.length).toBeLessThan(4 * 402);
    expect(values[1]).toContain(900);
    expect(values[0]).not.toContain(900);
  });

  it("does not take the distance between wide buckets for a gap", () => {
    const columns = rows(0, 40_000, [2000, 2100]);
    expect(drawing(columns, null, ["A"], 0, 4000, 100).holes[0]).toHaveLength(1);
  });

  it("does not take the distance between decimated rows for a gap", () => {
    const thin = new Columns();
    // The lowest and the highest of each stretch lie close together, the stretches far apart.
    const times = Array.from({ length: 100 }, (_, row) => (row >> 3) * 7 + (row % 8) / 100);
    thin.append(["A"], times, [times]);
    expect(drawing(thin, null, ["A"], 0, 700, 300).holes[0]!.length).toBeGreaterThan(10);
    thin.spacing = 28;
    expect(drawing(thin, null, ["A"], 0, 700, 300).holes[0]).toEqual([]);
  });
});
