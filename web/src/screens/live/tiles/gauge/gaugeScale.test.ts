import { describe, expect, it } from "vitest";
import type { Channel } from "../../../../lib/api/types";
import { arc, bandsOf, beyond, dash, rangeOf, share, turned, visible } from "./gaugeScale";

const channel = (about: Partial<Channel>): Channel => about as Channel;

describe("a gauge's range", () => {
  it("is the catalog's, whatever the values", () => {
    expect(rangeOf(channel({ gauge: [0, 7000] }))).toEqual({ low: 0, high: 7000 });
  });

  it("is the tile's own, if that has one", () => {
    expect(rangeOf(channel({ gauge: [0, 7000] }), [0, 2000])).toEqual({ low: 0, high: 2000 });
    expect(rangeOf(channel({ gauge: [0, 7000] }), [9, 9])).toEqual({ low: 0, high: 7000 });
  });

  it("shows a narrow band around its middle, inside the arc", () => {
    const rounded = (from: number, to: number) => visible(from, to).map((at) => Number(at.toFixed(3)));
    expect(rounded(0.123, 0.138)).toEqual([0.116, 0.146]);
    expect(rounded(0.2, 0.5)).toEqual([0.2, 0.5]);
    expect(rounded(0, 0)).toEqual([0, 0.03]);
    expect(rounded(1, 1)).toEqual([0.97, 1]);
  });

  it("does not exist without one", () => {
    expect(rangeOf(undefined)).toBeNull();
    expect(rangeOf(channel({ gauge: null, range: [0, 5], reference: [1, 2] }))).toBeNull();
    expect(rangeOf(channel({ gauge: [3, 3] }))).toBeNull();
  });

  it("says on which side a value lies beyond", () => {
    const range = { low: -10, high: 50 };
    expect([-10.5, -10, 50, 50.5].map((value) => beyond(value, range))).toEqual(["low", null, null, "high"]);
  });
});

describe("its bands", () => {
  const range = { low: 0, high: 20 };

  it("follow the four limits", () => {
    const limits = { danger_low: 5, warning_low: 10, warning_high: 15, danger_high: 18, hysteresis: 0 };
    expect(bandsOf(channel({ limits }), range)).toEqual([
      { from: 0, to: 0.25, level: "danger" },
      { from: 0.25, to: 0.5, level: "warning" },
      { from: 0.75, to: 0.9, level: "warning" },
      { from: 0.9, to: 1, level: "danger" },
    ]);
  });

  it("extend to the end without a danger limit, and omit missing limits", () => {
    const limits = { danger_low: null, warning_low: 10, warning_high: null, danger_high: 18, hysteresis: 0 };
    expect(bandsOf(channel({ limits }), range)).toEqual([
      { from: 0, to: 0.5, level: "warning" },
      { from: 0.9, to: 1, level: "danger" },
    ]);
    expect(bandsOf(channel({}), range)).toEqual([]);
  });

  it("stay on the arc", () => {
    expect(share(25, range)).toBe(1);
    expect(share(-3, range)).toBe(0);
    expect(arc(0, 1, 80)).toContain("A80 80 0 1 1");
    expect(arc(0, 0.5, 80)).toContain("A80 80 0 0 1");
  });

  it("show a part of the arc as a dash, and turn the needle", () => {
    expect(dash(0.25, 0.75)).toBe("0 0.2500 0.5000 1");
    expect([0, 0.5, 1].map((at) => turned(at))).toEqual(["rotate(0.00 100 92)", "rotate(120.00 100 92)", "rotate(240.00 100 92)"]);
  });
});
