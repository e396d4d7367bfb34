import { describe, expect, it } from "vitest";
import type { Channel } from "../../../lib/api/types";
import { arc, bandsOf, rangeOf, share } from "./gaugeScale";

const channel = (about: Partial<Channel>): Channel => ({
  name: "X",
  derived: false,
  flag: false,
  code: 1,
  size: 1,
  unit: { en: "", ru: "" },
  text: { en: "", ru: "" },
  short: { en: "", ru: "" },
  decimals: 0,
  formula: "",
  range: null,
  reference: null,
  gauge: null,
  span_least: null,
  limits: null,
  lamp: null,
  alarm_when_true: "none",
  inputs: null,
  errata: [],
  confidence: "reported",
  writable: false,
  ...about,
}) as Channel;

describe("a gauge's range", () => {
  it("is the plausible range", () => {
    expect(rangeOf(channel({ range: [-40, 130] }))).toEqual({ low: -40, high: 130 });
  });

  it("keeps limits in place, and is narrower without limits", () => {
    const limits = { danger_low: null, warning_low: null, warning_high: 6000, danger_high: null, hysteresis: 0 };
    expect(rangeOf(channel({ range: [0, 6500], reference: [800, 900], limits })).high).toBe(6500);
    expect(rangeOf(channel({ range: [0, 450], reference: [13, 16] }), { min: 14, max: 15 }).high).toBe(20);
    expect(rangeOf(channel({ range: [0, 450], reference: [13, 16] }), { min: 14, max: 440 }).high).toBe(450);
    expect(rangeOf(channel({ range: [0, 100], reference: [0, 0] })).high).toBe(100);
  });

  it("contains reference, limits and values seen, with room", () => {
    const range = rangeOf(channel({ reference: [800, 900] }), { min: 780, max: 2100 });
    expect(range.low).toBe(0);
    expect(range.high).toBeGreaterThan(2100);
  });

  it("goes below zero where values do", () => {
    const range = rangeOf(channel({}), { min: -7, max: 3 });
    expect(range.low).toBeLessThan(-7);
    expect(range.high).toBeGreaterThan(3);
  });

  it("exists for an unknown channel and for a constant one", () => {
    expect(rangeOf(undefined)).toEqual({ low: 0, high: 1 });
    const still = rangeOf(channel({}), { min: 0, max: 0 });
    expect(still.high).toBeGreaterThan(still.low);
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
});
