import { expect, it } from "vitest";
import type { Channel } from "../../../../lib/api/types";
import type { Line } from "../../../../lib/series/valueAxis";
import { steadyAxes } from "./stripScale";

const channel = (unit: string, span_least: number) => ({ unit: { en: unit, ru: unit }, span_least, flag: false }) as Channel;
const RPM = channel("rpm", 100);
const VOLT = channel("V", 2);
const line = (name: string, of: Channel, min: number, max: number): Line => ({ name, channel: of, seen: { min, max } });

it("axes stay while the values fit, and follow values that leave them or shrink", () => {
  const first = steadyAxes([line("A", RPM, 700, 900), line("B", RPM, 800, 850)], [], 100);
  expect(first[1]).toEqual(first[0]);
  const slightly = [line("A", RPM, 705, 890), line("B", RPM, 800, 850)];
  expect(steadyAxes(slightly, first, 100)).toBe(first);
  expect(steadyAxes([line("A", RPM, 700, 1400), slightly[1]!], first, 100)[0]!.high).toBeGreaterThan(1400);
  const wide = steadyAxes([line("A", RPM, 0, 3000), line("B", RPM, 800, 850)], [], 100);
  expect(steadyAxes(slightly, wide, 100)).not.toBe(wide);
  expect(steadyAxes([slightly[0]!], first, 100)).toHaveLength(1);
});

it("axes change when constant lines have come to lie on each other", () => {
  const before = steadyAxes([line("A", RPM, 800, 900), line("B", VOLT, 14, 14)], [], 100);
  const level = before[0]!.low + (before[0]!.high - before[0]!.low) * ((14 - before[1]!.low) / (before[1]!.high - before[1]!.low));
  const still = [line("A", RPM, level, level), line("B", VOLT, 14, 14)];
  const [one, other] = steadyAxes(still, before, 100);
  const heights = [(level - one!.low) / (one!.high - one!.low), (14 - other!.low) / (other!.high - other!.low)];
  expect(Math.abs(heights[0]! - heights[1]!)).toBeGreaterThan(0.04);
});
