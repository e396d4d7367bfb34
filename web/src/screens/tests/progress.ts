// What a run shows: its progress, its countdown, values against targets, curves as paths. Pure.
import type { TestCurve, TestRun } from "../../lib/api/types";

export type Fit = "in" | "low" | "high" | "none";

/** Where a value stands to its target. */
export function fitOf(value: number | undefined, target: readonly number[] | undefined): Fit | null {
  if (!target) return null;
  if (value === undefined) return "none";
  if (value < target[0]!) return "low";
  return value > target[1]! ? "high" : "in";
}

/** The share of the test that is done, 0 to 1: whole steps, and of a step that holds its part. */
export function shareDone(run: Pick<TestRun, "phase" | "step" | "steps" | "held" | "hold">): number {
  if (run.phase === "done") return 1;
  if (run.step === null) return 0;
  const part = run.phase === "hold" && run.hold > 0 ? Math.min(1, run.held / run.hold) : 0;
  return (run.step + part) / run.steps.length;
}

/** The seconds that the phase shows: left of preparation or hold, else passed. */
export function secondsShown(run: Pick<TestRun, "phase" | "seconds" | "held" | "hold" | "prepare">): number {
  if (run.phase === "prepare") return Math.max(0, Math.ceil(run.prepare - run.seconds));
  if (run.phase === "hold") return Math.max(0, Math.ceil(run.hold - run.held));
  return Math.floor(run.seconds);
}

/** Points of a curve in a box with the values `low` … `high`: the lowest and highest value of each span, so that spikes stay. */
export function pathOf(
  curve: Pick<TestCurve, "times" | "lows" | "highs">,
  { low, high }: { low: number; high: number },
  width: number,
  height: number,
): string {
  const { times, lows, highs } = curve;
  if (times.length < 2) return "";
  const began = times[0]!;
  const length = times[times.length - 1]! - began || 1;
  const point = (time: number, value: number) =>
    `${(((time - began) / length) * width).toFixed(1)},${(height - ((value - low) / (high - low)) * height).toFixed(1)}`;
  return times.map((time, at) => `${point(time, lows[at]!)} ${point(time, highs[at]!)}`).join(" ");
}
