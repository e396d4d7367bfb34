import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import type { Channel } from "../api/types";
import { axesOf, axisAlone, fitted, leastSpan, neverNegative, type Line } from "./valueAxis";

const channel = (unit: string, more: Partial<Channel> = {}): Channel =>
  ({ unit: { en: unit, ru: unit }, flag: false, decimals: 0, range: null, gauge: null, span_least: null, ...more }) as Channel;
const TWAT = channel("°C", { range: [-40, 130], span_least: 20 });
const UACC = channel("V", { range: [0, 20], span_least: 2, decimals: 1 });
const FREQ = channel("rpm", { range: [0, 6500], span_least: 500 });
const THR = channel("%", { range: [0, 100], span_least: 10 });
const DET = channel("", { flag: true });

const line = (name: string, of: Channel | undefined, min: number, max = min): Line => ({ name, channel: of, seen: { min, max } });
const HEIGHT = 200;

/** The heights of the lines' middles, as shares of the pane. */
function heights(lines: readonly Line[]): number[] {
  const axes = axesOf(lines, HEIGHT);
  return lines.map(({ seen }, index) => {
    const { low, high } = axes[index]!;
    return ((seen!.min + seen!.max) / 2 - low) / (high - low);
  });
}

/** A small generator of repeatable numbers from 0 to 1. */
function numbers(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state * 1103515245 + 12345) % 2147483648;
    return state / 2147483648;
  };
}

describe("an axis", () => {
  it("contains the range that is shown behind its line, which is no value of the line", () => {
    const { low, high } = axesOf([{ ...line("TWAT", TWAT, 20), band: [80, 92] }], HEIGHT)[0]!;
    expect(low).toBeLessThan(20);
    expect(high).toBeGreaterThan(92);
    expect(axesOf([{ ...line("TWAT", TWAT, 0), seen: null, band: [80, 92] }], HEIGHT)[0]!.low).toBeGreaterThan(60);
  });

  it("contains the values with room", () => {
    const { low, high } = fitted({ min: 0, max: 3000, least: 500, floor: false });
    expect(low).toBeLessThan(0);
    expect(high).toBeGreaterThan(3000);
  });

  it("is not narrower than the least span: 0.1 V does not fill it", () => {
    const { low, high } = fitted({ min: 14.1, max: 14.2, least: 2, floor: true });
    expect(high - low).toBeCloseTo(2);
    expect((14.15 - low) / 2).toBeCloseTo(0.5);
  });

  it("begins at 0 where nothing is below: a standing engine has no negative speed", () => {
    const { low, high, floor } = fitted({ min: 0, max: 0, least: 500, floor: true });
    expect(floor).toBe(true);
    expect(low).toBeGreaterThan(-0.05 * 500); // room for the line, without labels
    expect(high).toBeGreaterThan(475);
    expect(fitted({ min: -1, max: 0, least: 10, floor: true }).floor).toBe(false); // seen all the same
  });

  it("of a channel alone follows the same rules, and a flag has room", () => {
    expect(axisAlone(FREQ, { min: 0, max: 0 }).low).toBeGreaterThan(-50);
    const idle = axisAlone(FREQ, { min: 840, max: 880 });
    expect(idle.high - idle.low).toBe(500);
    expect(axisAlone(DET, { min: 1, max: 1 })).toEqual({ low: -0.2, high: 1.2 });
    const huge = axisAlone(undefined, { min: 1e30, max: 1e30 });
    expect(huge.high).toBeGreaterThan(huge.low);
  });

  it("knows from the catalog what can't be negative, and how fine it should be", () => {
    expect([TWAT, UACC, undefined].map(neverNegative)).toEqual([false, true, true]);
    expect(neverNegative(channel("mg", { gauge: [-1, 1] }))).toBe(false);
    expect([UACC, channel("", { decimals: 2 }), undefined].map(leastSpan)).toEqual([2, 0.1, 10]);
  });
});

describe("the axes of a pane", () => {
  it("keep coolant and voltage apart when both are constant", () => {
    const [coolant, voltage] = heights([line("TWAT", TWAT, 117), line("UACC", UACC, 13.8)]);
    expect(coolant! - voltage!).toBeGreaterThan(0.1);
  });

  it("keep the zeros of a standing engine apart", () => {
    const [speed, throttle] = heights([line("FREQ", FREQ, 0), line("THR", THR, 0)]);
    expect(Math.abs(speed! - throttle!)).toBeGreaterThanOrEqual(0.05 - 1e-9);
    for (const height of [speed!, throttle!]) expect(height).toBeGreaterThan(0);
  });

  it("are shared by one unit; equal values are drawn side by side, three pixels apart", () => {
    const [one, other] = axesOf([line("A", TWAT, 20, 60), line("B", TWAT, 40, 90)], HEIGHT);
    expect(other).toEqual(one);
    const [first, second, third] = heights([line("A", TWAT, 20), line("B", TWAT, 20), line("C", TWAT, 20)]);
    expect((second! - first!) * HEIGHT).toBeCloseTo(3);
    expect((third! - first!) * HEIGHT).toBeCloseTo(6);
  });

  it("part moving lines too, if they have the same points", () => {
    const cells = (...values: number[]) => ({ ...line("", TWAT, Math.min(...values), Math.max(...values)), cells: values });
    const [set, position, lagging] = axesOf([cells(1, 5, 9), cells(1, 5, 9), cells(1, 9, 9)], HEIGHT);
    expect(position!.low).toBeLessThan(set!.low);
    expect(lagging).toEqual(set);
  });

  it("give each flag a strip at the foot", () => {
    const axes = axesOf([line("DET", DET, 0), line("RXX", DET, 1), line("UACC", UACC, 13.8)], HEIGHT);
    const at = (index: number, value: number) => (value - axes[index]!.low) / (axes[index]!.high - axes[index]!.low);
    expect(at(0, 0)).toBeGreaterThan(0);
    expect(at(0, 1)).toBeLessThan(at(1, 0));
    expect(at(1, 1)).toBeLessThan(0.6);
  });

  it("contain a line without values", () => {
    const [axis] = axesOf([{ name: "A", channel: UACC, seen: null }], HEIGHT);
    expect(axis!.high).toBeGreaterThan(axis!.low);
  });

  it("never let two constant lines cover each other, whatever their values", () => {
    const kinds = [TWAT, UACC, FREQ, THR, DET, channel("mg", { span_least: 5 }), channel("", { span_least: 0.1 }), undefined];
    const tooNear: number[] = [];
    for (let seed = 1; seed <= 400; seed += 1) {
      const next = numbers(seed * 7919);
      const count = 2 + Math.floor(next() * 6);
      const lines = Array.from({ length: count }, (_, index) => {
        const of = kinds[Math.floor(next() * kinds.length)];
        const step = of?.flag ? 1 : (of?.span_least ?? 10) / 20;
        const value = of?.flag ? Math.round(next()) : Math.round(next() * 12) * step;
        return line(`${index}`, of, value);
      });
      const found = [0, ...heights(lines).sort((one, other) => one - other), 1];
      const nearest = Math.min(...found.slice(1).map((height, index) => height - found[index]!));
      if (nearest * HEIGHT <= 1.9) tooNear.push(seed);
    }
    expect(tooNear).toEqual([]);
  });
});

describe("the cases that a plot in a notebook is held to as well (tests/notebook)", () => {
  interface Case {
    lines: {
      name: string;
      flag: boolean;
      unit: string;
      span_least: number | null;
      lowest: number | null;
      seen: Line["seen"];
      band: [number, number] | null;
    }[];
    axes: { low: number; high: number; floor: boolean }[];
  }
  const cases = JSON.parse(readFileSync(new URL("./valueAxis.test.json", import.meta.url), "utf8")) as Case[];

  it("have these axes", () => {
    for (const { lines, axes } of cases) {
      const found = axesOf(
        lines.map(({ name, flag, unit, span_least, lowest, seen, band }) => {
          const channel = { flag, unit: { en: unit, ru: unit }, span_least, decimals: 0, range: lowest === null ? null : [lowest, 9999] };
          return { name, channel: channel as unknown as Channel, seen, band: band ?? undefined };
        }),
        400,
      );
      found.forEach(({ low, high, floor }, line) => {
        expect(low).toBeCloseTo(axes[line]!.low, 9);
        expect(high).toBeCloseTo(axes[line]!.high, 9);
        expect(floor).toBe(axes[line]!.floor);
      });
    }
  });
});
