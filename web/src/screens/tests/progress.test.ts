import { expect, test } from "vitest";
import { fitOf, pathOf, secondsShown, shareDone } from "./progress";

test("a value against its target", () => {
  expect([11, 12, 13, 14].map((value) => fitOf(value, [12, 13]))).toEqual(["low", "in", "in", "high"]);
  expect([fitOf(undefined, [12, 13]), fitOf(12, undefined)]).toEqual(["none", null]);
});

test("progress counts whole steps, and the part of a hold", () => {
  const steps = [{}, {}, {}, {}] as never[];
  const at = (phase: string, step: number | null, held = 0) => shareDone({ phase, step, steps, held, hold: 8 } as never);
  expect([at("start", null), at("until", 1), at("hold", 1, 4), at("hold", 1, 99), at("done", null)]).toEqual([0, 0.25, 0.375, 0.5, 1]);
});

test("seconds are counted down while one has to wait or hold, else up", () => {
  const shown = (phase: string) => secondsShown({ phase, seconds: 3.2, held: 2.5, hold: 8, prepare: 10 } as never);
  expect(["prepare", "hold", "until"].map(shown)).toEqual([7, 6, 3]);
});

test("a curve keeps its spikes", () => {
  const curve = { times: [0, 1, 2], lows: [0, 0, 0], highs: [0, 10, 0] };
  expect(pathOf(curve, { low: 0, high: 10 }, 100, 50)).toBe("0.0,50.0 0.0,50.0 50.0,50.0 50.0,0.0 100.0,50.0 100.0,50.0");
  expect(pathOf({ times: [5], lows: [1], highs: [1] }, { low: 0, high: 10 }, 100, 50)).toBe("");
});
