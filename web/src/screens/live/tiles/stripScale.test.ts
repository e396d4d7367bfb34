import { expect, it } from "vitest";
import type { Channel } from "../../../lib/api/types";
import { scalesOf } from "./stripScale";

const channel = (unit: string, span_least: number) => ({ unit: { en: unit, ru: unit }, span_least }) as Channel;

it("lines with the same unit share a scale; a line without values has none", () => {
  const known: Record<string, Channel> = { A: channel("rpm", 100), B: channel("rpm", 50), C: channel("", 2) };
  const seen: Record<string, { min: number; max: number }> = { A: { min: 800, max: 900 }, B: { min: 700, max: 800 }, C: { min: 1, max: 1 } };
  const scales = scalesOf(["A", "B", "C", "D"], new Map(), (name) => known[name], (name) => seen[name]);
  expect(scales.get("A")).toBe(scales.get("B"));
  expect(scales.get("A")).toEqual({ low: 670, high: 930 });
  expect(scales.get("C")).toEqual({ low: 0, high: 2 });
  expect(scales.has("D")).toBe(false);
  const again = scalesOf(["A", "B"], scales, (name) => known[name], () => ({ min: 720, max: 890 }));
  expect(again.get("A")).toBe(scales.get("A"));
});
