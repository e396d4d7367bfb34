// The steps of the connection check as they are drawn: all of them, with the results so far.

import type { DoctorStep } from "../../../lib/api/types";

export const STEPS = ["port", "echo", "baud", "latency", "line", "ecu", "commands"] as const;
export type StepName = (typeof STEPS)[number];
export type StepMark = "ok" | "bad" | "unsure" | "running" | "todo" | "skipped";

export interface MarkedStep {
  name: StepName;
  mark: StepMark;
  step: DoctorStep | null;
}

/**
 * Mark each step. A step without a result before one with a result was left out (an adapter without echo has no speed to measure); one
 * after the end was not reached.
 */
export function markSteps(steps: readonly DoctorStep[], running: boolean): MarkedStep[] {
  const known = new Map(steps.map((step) => [step.name, step]));
  const reached = Math.max(-1, ...steps.map((step) => STEPS.findIndex((name) => name === step.name)));
  return STEPS.map((name, at) => {
    const step = known.get(name) ?? null;
    if (step) return { name, step, mark: step.ok === null ? "unsure" : step.ok ? "ok" : "bad" };
    const mark = !running || at < reached ? "skipped" : at === reached + 1 ? "running" : "todo";
    return { name, step, mark };
  });
}

/** Whether the check came to its end without a failed step. */
export const passed = (steps: readonly DoctorStep[]): boolean =>
  steps.at(-1)?.name === STEPS.at(-1) && steps.every((step) => step.ok !== false);

export type Outcome = "well" | "works" | "broken" | "stopped";

/** The outcome of a finished check. Without a failure and without its last step it was stopped. */
export function outcomeOf(steps: readonly DoctorStep[]): Outcome {
  if (steps.some((step) => step.ok === false)) return "broken";
  if (!passed(steps)) return "stopped";
  return steps.every((step) => step.ok) ? "well" : "works";
}
