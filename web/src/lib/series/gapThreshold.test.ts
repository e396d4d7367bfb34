import { describe, expect, it } from "vitest";
import { gapThreshold } from "./gapThreshold";
import { Columns } from "./columns";

/** A value every `every` seconds; none from..to. */
function rows(every: number, count: number, none: [number, number] = [0, 0]): Columns {
  const columns = new Columns();
  const times = Array.from({ length: count }, (_, row) => 100 + row * every).filter((time) => time < none[0] || time >= none[1]);
  columns.append(["A"], times, [times]);
  return columns;
}

describe("gapThreshold", () => {
  it("follows the channel's usual interval", () => {
    expect(gapThreshold(rows(1 / 30, 900), "A")).toBe(0.5);
    expect(gapThreshold(rows(0.2, 300), "A")).toBeCloseTo(1);
    expect(gapThreshold(rows(4, 50), "A")).toBeCloseTo(20);
  });

  it("is not changed by the gap itself", () => {
    expect(gapThreshold(rows(0.05, 600, [110, 125]), "A")).toBe(0.5);
  });

  it("works for sparse columns", () => {
    const columns = new Columns();
    const times = Array.from({ length: 600 }, (_, row) => row / 30);
    columns.append(["A"], times, [times.map((time, row) => (row % 10 ? null : time))]);
    expect(gapThreshold(columns, "A")).toBeCloseTo(5 / 3);
  });

  it("is three seconds with too few values, and at least the spacing of decimated rows", () => {
    expect(gapThreshold(rows(0.1, 2), "A")).toBe(3);
    expect(gapThreshold(rows(0.1, 2), "B")).toBe(3);
    const thin = rows(1, 50);
    thin.spacing = 28;
    expect(gapThreshold(thin, "A")).toBe(28);
  });
});
