import { describe, expect, it } from "vitest";
import type { DoctorStep } from "../../../lib/api/types";
import { foundNoMikas, markSteps, outcomeOf } from "./steps";

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
  it("has the tries for another kind of unit where they were asked for", () => {
    const silent = [step("port", true), step("echo", true), step("baud", true), step("ecu", false)];
    // Without an answer the commands are skipped, and only the next result shows it.
    expect(
      markSteps(silent, true, true)
        .slice(-5)
        .map((it) => it.mark),
    ).toEqual(["running", "todo", "todo", "todo", "todo"]);
    const named = [...silent, step("unasked", null), step("other-baud", null), step("kwp2000-fast", true)];
    expect(
      markSteps(named, true, true)
        .slice(-5)
        .map((it) => it.mark),
    ).toEqual(["skipped", "unsure", "unsure", "ok", "running"]);
    expect(markSteps(named, false).length).toBe(7);
    expect(outcomeOf(named)).toBe("broken");
  });
  it("found no Mikas if the way ended at the echo or the unit", () => {
    expect(foundNoMikas([step("port", true), step("echo", false)])).toBe(true);
    expect(foundNoMikas([step("port", false)])).toBe(false);
    expect(foundNoMikas([step("ecu", true), step("commands", true)])).toBe(false);
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
