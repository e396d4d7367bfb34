import { describe, expect, it } from "vitest";
import type { DoctorStep } from "../../../lib/api/types";
import { markSteps, outcomeOf } from "./steps";

describe("the connection check", () => {
  const text = { en: "", ru: "" };
  const step = (name: string, ok: boolean | null): DoctorStep => ({
    name,
    ok,
    code: null,
    port: "",
    title: text,
    detail: text,
    to_try: null,
  });
  const marks = (steps: DoctorStep[], running: boolean) => markSteps(steps, running).map((it) => it.mark);

  it("marks running and pending steps", () => {
    expect(marks([], true)).toEqual(["running", "todo", "todo", "todo", "todo", "todo", "todo"]);
    expect(marks([step("port", true)], true).slice(0, 3)).toEqual(["ok", "running", "todo"]);
  });
  it("marks skipped steps and those not reached", () => {
    const steps = [step("port", true), step("echo", true), step("latency", null)];
    expect(marks(steps, true)).toEqual(["ok", "ok", "skipped", "unsure", "running", "todo", "todo"]);
    const broken = [step("port", true), step("echo", false)];
    expect(marks(broken, false)).toEqual(["ok", "bad", "skipped", "skipped", "skipped", "skipped", "skipped"]);
  });
  it("has an outcome", () => {
    const last = step("commands", true);
    expect(outcomeOf([step("port", true), last])).toBe("well");
    expect(outcomeOf([step("port", true), step("line", null), last])).toBe("works");
    expect(outcomeOf([step("line", null), step("ecu", false)])).toBe("broken");
  });
  it("is stopped without its last step", () => {
    expect(outcomeOf([step("port", true), step("echo", true)])).toBe("stopped");
  });
});
