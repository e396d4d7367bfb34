// The steps of the connection check as they are drawn: all of them, with the results so far.

import type { DoctorStep } from "../../../lib/api/types";

export const STEPS = ["port", "echo", "baud", "latency", "line", "ecu", "commands"] as const;
/** The tries for another kind of unit, where no Mikas answers. */
export const OTHER_UNITS = ["unasked", "other-baud", "kwp2000-fast", "kwp2000-slow"] as const;
export type StepName = (typeof STEPS)[number] | (typeof OTHER_UNITS)[number];
export type StepMark = "ok" | "bad" | "unsure" | "running" | "todo" | "skipped";

export interface MarkedStep {
  name: StepName;
  mark: StepMark;
  step: DoctorStep | null;
}

/** Whether the line works as far as it goes, and the check found no Mikas on it. */
export const foundNoMikas = (steps: readonly DoctorStep[]): boolean =>
  steps.some(({ name, ok }) => (name === "echo" || name === "ecu") && ok === false);

/**
 * Mark each step; those of other units if they were asked for. A step without a result before one with a result was left out (an adapter without echo has no speed to measure); one
 * after the end was not reached.
 */
export function markSteps(steps: readonly DoctorStep[], running: boolean, others = false): MarkedStep[] {
  const all: readonly StepName[] = others ? [...STEPS, ...OTHER_UNITS] : STEPS;
  const known = new Map(steps.map((step) => [step.name, step]));
  const reached = Math.max(-1, ...steps.map((step) => all.findIndex((name) => name === step.name)));
  return all.map((name, at) => {
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
