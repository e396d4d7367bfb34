import { describe, expect, it } from "vitest";
import { mapOf, passOf, percent, secondsFor } from "./blocks";

describe("the map of blocks", () => {
  it("has counts and a layout", () => {
    const blocks = Array.from({ length: 70 }, (_, at) => ({
      first: at * 16,
      count: 16,
      state: at < 2 ? ("done" as const) : at === 2 ? ("retried" as const) : ("todo" as const),
    }));
    const map = mapOf(blocks);
    expect([map.columns, map.rows]).toEqual([32, 3]);
    expect(map.counts).toEqual({ done: 2, retried: 1, failed: 0, todo: 67 });
    expect(map.cells[33]).toMatchObject({ column: 1, row: 1 });
    expect(mapOf([])).toMatchObject({ rows: 1, cells: [] });
  });
  it("shows 100 % only when complete", () => {
    expect(percent(65535, 65536)).toBe(99);
    expect(percent(65536, 65536)).toBe(100);
    expect(percent(0, 0)).toBe(0);
  });
  it("estimates 72 s for 64 KiB (§5)", () => {
    expect(secondsFor("code", 65536, 255)).toBeGreaterThan(70);
    expect(secondsFor("code", 65536, 255)).toBeLessThan(74);
  });
  it("counts 258 requests for 64 KiB, the last one of a single byte (§5)", () => {
    const each = 10 / 960 + 0.002;
    const bytes = (65536 * (1 + 2 / 256)) / 960;
    expect((secondsFor("code", 65536, 255) - bytes) / each).toBeCloseTo(258, 6);
  });
});

it("a verified dump has two passes over the same bytes", () => {
  const dump = { first: 0x100, last: 0x1ff, total: 512 };
  expect(passOf({ ...dump, done: 100 })).toEqual({ done: 100, size: 256, pass: 1, passes: 2 });
  expect(passOf({ ...dump, done: 300 })).toEqual({ done: 44, size: 256, pass: 2, passes: 2 });
  expect(passOf({ ...dump, done: 512 })).toEqual({ done: 256, size: 256, pass: 2, passes: 2 });
  expect(passOf({ ...dump, total: 256, done: 256 })).toEqual({ done: 256, size: 256, pass: 1, passes: 1 });
});
