import { describe, expect, it } from "vitest";
import { Columns } from "./columns";
import { steadyScale } from "./rollingTraces";
import { drawTrace } from "./sparkline";

describe("a small line's scale", () => {
  it("has room, and is never narrower than the least span", () => {
    expect(steadyScale(undefined, { min: 100, max: 200 }, 10)).toEqual({ low: 85, high: 215 });
    expect(steadyScale(undefined, { min: 13.8, max: 13.9 }, 2)).toEqual({ low: 12.850000000000001, high: 14.850000000000001 });
  });

  it("grows at once and shrinks only when most of it is empty", () => {
    const before = { low: 0, high: 100 };
    expect(steadyScale(before, { min: 30, max: 70 }, 10)).toBe(before);
    expect(steadyScale(before, { min: 50, max: 101 }, 10).high).toBeGreaterThan(101);
    expect(steadyScale(before, { min: 50, max: 60 }, 10)).toEqual({ low: 48.5, high: 61.5 });
  });
});

describe("a line that is continued", () => {
  const columns = new Columns();
  const times = Array.from({ length: 200 }, (_, row) => row / 10);
  columns.append(["A", "B"], times, [times.map((time) => Math.sin(time)), times.map((_, row) => (row % 7 ? null : row))]);

  /** The points of the path with their places: [x, y]. */
  function path(name: string, from: number, to: number, after?: number): string[] {
    const points: string[] = [];
    const note = (x: number, y: number) => void points.push(`${x} ${y.toFixed(6)}`);
    drawTrace({ moveTo: note, lineTo: note }, columns, name, { from, to, low: -2, high: 200 }, 100, 40, 2, after);
    return points;
  }

  it.each(["A", "B"])("has the points of the whole line (%s)", (name) => {
    // 0.1 s a pixel: one row in each.
    const whole = path(name, 9, 19);
    const piece = path(name, 9, 19, 18);
    expect(piece.length).toBeGreaterThan(1);
    expect(piece.length).toBeLessThan(20);
    expect(whole.slice(-piece.length)).toEqual(piece);
  });

  it("shifted by whole pixels, an older picture has the same points", () => {
    const older = path("A", 8, 18);
    const newer = new Set(path("A", 9, 19));
    const moved = older.map((point) => point.split(" ")).map(([x, y]) => `${Number(x) - 10} ${y}`);
    expect(moved.filter((point) => Number(point.split(" ")[0]) > 0).every((point) => newer.has(point))).toBe(true);
  });
});
