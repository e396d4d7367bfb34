import { describe, expect, it } from "vitest";
import { lane, paneAxes, stretched } from "./scales";

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

describe("the axes of a stacked pane", () => {
  it("keep each trace, and the second recording's, in a lane of its own", () => {
    const line = (name: string, min: number, max: number) => ({ name, channel: undefined, seen: { min, max } });
    const axes = paneAxes([line("A", 0, 100), line("B", 5, 5), line("A", 20, 200), line("B", 5, 5)], 2, true, 400);
    const height = (index: number, value: number) => (value - axes[index]!.low) / (axes[index]!.high - axes[index]!.low);
    for (const [index, value] of [
      [0, 0],
      [0, 100],
      [2, 20],
      [2, 200],
    ] as const) {
      expect(height(index, value)).toBeGreaterThan(0.5);
      expect(height(index, value)).toBeLessThan(1);
    }
    expect(height(1, 5)).toBeGreaterThan(0);
    expect(height(1, 5)).toBeLessThan(0.5);
    expect(height(3, 5)).toBeGreaterThan(height(1, 5));
  });
});
