import { describe, expect, it } from "vitest";
import { fitting, lane, stretched } from "./scales";

describe("fitting", () => {
  it("adds room", () => {
    const [low, high] = fitting(0, 100, 1);
    expect(low).toBeLessThan(0);
    expect(high).toBeGreaterThan(100);
  });

  it("does not enlarge noise", () => {
    const [low, high] = fitting(14.1, 14.2, 0.8);
    expect(low).toBeCloseTo(13.75);
    expect(high).toBeCloseTo(14.55);
    expect(fitting(5, 5, 2)).toEqual([4, 6]);
    expect(fitting(null, null, 1)).toEqual([0, 1]);
  });
});

describe("stretched", () => {
  it("scales around the centre and shifts by shares", () => {
    expect(stretched([0, 10], undefined)).toEqual([0, 10]);
    expect(stretched([0, 10], { shift: 0, scale: 0.5 })).toEqual([2.5, 7.5]);
    expect(stretched([0, 10], { shift: 0.5, scale: 1 })).toEqual([5, 15]);
  });
});

describe("lane", () => {
  it("places each range in its own part, the first at the top", () => {
    const height = 300;
    const at = (value: number, [low, high]: [number, number]) => height - ((value - low) / (high - low)) * height;
    for (const index of [0, 1, 2]) {
      const range = lane([20, 40], index, 3);
      expect(at(40, range)).toBeCloseTo(index * 100);
      expect(at(20, range)).toBeCloseTo((index + 1) * 100);
    }
  });
});
