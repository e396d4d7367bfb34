// The steps of the connection check as they are drawn: all of them, with the results so far.

import type { DoctorStep } from "../../lib/api/types";

export const STEPS = ["port", "echo", "baud", "latency", "line", "ecu", "commands"] as const;
export type StepName = (typeof STEPS)[number];
export type Mark = "ok" | "bad" | "unsure" | "running" | "todo" | "skipped";

export interface MarkedStep {
  name: StepName;
  mark: Mark;
  step: DoctorStep | null;
}

/**
 * Mark each step. A step without a result before one with a result was left out (an adapter without echo has no speed to measure); one
 * after the end was not reached.
 */
export function markSteps(steps: readonly DoctorStep[], running: boolean): MarkedStep[] {
  const known = new Map(steps.map((step) => [step.name, step]));
  const reached = Math.max(
    -1,
    ...steps.map((step) => STEPS.findIndex((name) => name === step.name)),
  );
  return STEPS.map((name, at) => {
    const step = known.get(name) ?? null;
    if (step) return { name, step, mark: step.ok === null ? "unsure" : step.ok ? "ok" : "bad" };
    const mark = !running || at < reached ? "skipped" : at === reached + 1 ? "running" : "todo";
    return { name, step, mark };
  });
}

export type Verdict = "well" | "works" | "broken" | "stopped";

/** The verdict of a finished check. Without a failure and without its last step it was stopped. */
export function verdict(steps: readonly DoctorStep[]): Verdict {
  if (steps.some((step) => step.ok === false)) return "broken";
  if (steps.at(-1)?.name !== STEPS.at(-1)) return "stopped";
  return steps.every((step) => step.ok) ? "well" : "works";
}
