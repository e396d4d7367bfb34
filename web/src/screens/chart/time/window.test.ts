import { describe, expect, it } from "vitest";
import { around, LONGEST, SHORTEST, within, zoomed } from "./window";

const drive = { from: 1000, to: 1600 };
const inside = ({ from, to }: { from: number; to: number }, time: number) => time >= from - 1e-9 && time <= to + 1e-9;

describe("a window", () => {
  it("does not leave the recording", () => {
    expect(within(1100, 60, drive)).toEqual({ from: 1040, to: 1100 });
    expect(within(1020, 60, drive)).toEqual({ from: 1000, to: 1060 });
    expect(within(9000, 60, drive)).toEqual({ from: 1540, to: 1600 });
    expect(within(1300, 3600, drive)).toEqual(drive);
  });

  it("has a shortest and a longest length", () => {
    expect(within(10, 0, null)).toEqual({ from: 10 - SHORTEST, to: 10 });
    expect(within(10, 1e9, null)).toEqual({ from: 10 - LONGEST, to: 10 });
    expect(within(5, 1, { from: 5, to: 5 }).from).toBe(5);
  });

  it("zooms around a time that keeps its place", () => {
    expect(zoomed({ from: 1100, to: 1200 }, 50, 1180, drive)).toEqual({ from: 1140, to: 1190 });
    expect(zoomed({ from: 1000, to: 1100 }, 400, 1090, drive)).toEqual({ from: 1000, to: 1400 });
  });
});

describe("another length", () => {
  it("keeps the position in view, at its place", () => {
    expect(around(drive, 60, 1150, null, drive)).toEqual({ from: 1135, to: 1195 });
    expect(around(drive, 60, 1000, null, drive)).toEqual({ from: 1000, to: 1060 });
  });

  it("goes to a position outside", () => {
    expect(around({ from: 1500, to: 1600 }, 60, 1100, null, drive)).toEqual({ from: 1070, to: 1130 });
  });

  it("keeps position and cursor whenever both have room, and stays in the recording", () => {
    for (let at = 1000; at <= 1600; at += 37) {
      for (let cursor = 1000; cursor <= 1600; cursor += 41) {
        for (const span of [10, 60, 300]) {
          const found = around(drive, span, at, cursor, drive);
          expect(inside(found, at)).toBe(true);
          expect(inside(found, cursor)).toBe(Math.abs(cursor - at) <= span || (cursor >= found.from && cursor <= found.to));
          expect(found.from >= 1000 && found.to <= 1600).toBe(true);
          expect(found.to - found.from).toBeCloseTo(span);
        }
      }
    }
  });
});
