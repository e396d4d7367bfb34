import { describe, expect, it } from "vitest";
import { Columns } from "../../../../lib/series/columns";
import type { LineEvent } from "../../../../lib/api/types";
import { valueAt } from "./value";

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
