import { describe, expect, it } from "vitest";
import type { DoctorStep, Port, State } from "../../lib/api/types";
import { PINS } from "./diagnosticBlock";
import { markSteps, verdict } from "./steps";
import { bestGuess, situationOf } from "./situation";

const port = (url: string, likely: boolean): Port => ({ url, description: url, chip: "", likely, quirks: [] });
const state = (line: State["line"], more: Partial<State> = {}) => ({
  line,
  reason_code: null,
  port: null,
  model: null,
  samples: 0,
  ...more,
});

describe("which trouble it is", () => {
  it.each([
    ["sampling", "NoEcho", "ok"],
    ["ecu-alive", null, "ok"],
    ["no-echo", null, "no-echo"],
    ["echo-only", null, "echo-only"],
    ["off", "NoEcho", "no-echo"],
    ["off", "EchoOnly", "echo-only"],
    ["off", "NotAKLineAdapter", "elm327"],
    ["off", "PortBusy", "busy"],
    ["off", "PortDenied", "denied"],
    ["off", "LinkLost", "unplugged"],
    ["off", "Busy", "off"],
  ] as const)("%s, %s: %s", (line, code, wanted) => {
    expect(situationOf(state(line), [port("a", true)], code)).toBe(wanted);
  });
  it("with no adapter in the computer says so", () => {
    expect(situationOf(state("off"), [], null)).toBe("no-cable");
    expect(situationOf(state("off"), [port("ttyS0", false)], null)).toBe("no-cable");
    expect(situationOf(state("off"), [port("a", true)], null)).toBe("off");
    expect(situationOf(state("off"), [port("ttyS0", false)], "NoPortGiven")).toBe("no-cable");
    expect(situationOf(state("off"), [port("a", true), port("b", true)], "NoPortGiven")).toBe(
      "several",
    );
  });
  it("knows an ELM327 by the reason that the server gives", () => {
    const told = { reason_code: "NotAKLineAdapter" };
    expect(situationOf(state("no-echo", told), [], null)).toBe("elm327");
    expect(situationOf(state("off", told), [], null)).toBe("elm327");
  });
  it.each([
    ["/dev/ttyUSB0", null, "opening"],
    ["/dev/ttyUSB0", "PortBusy", "busy"],
    ["/dev/ttyUSB0", "PortDenied", "denied"],
    ["/dev/ttyUSB0", "PortNotFound", "no-port"],
    ["/etc/hostname", "PortFailed", "not-openable"],
    ["socket://127.0.0.1:1", "PortFailed", "no-adapter"],
    ["/dev/ttyUSB0", "LinkLost", "unplugged"],
    ["socket://127.0.0.1:1", "LinkLost", "closed"],
    ["replay:a.pcapng", "RecordingOver", "recording-ended"],
  ] as const)("tells why %s does not open: %s", (url, reason_code, wanted) => {
    expect(situationOf(state("no-port", { port: url, reason_code }), [], null)).toBe(wanted);
  });
  it("calls unplugged only what was there", () => {
    const missing = state("no-port", { port: "/dev/ttyUSB0", reason_code: "PortNotFound" });
    expect(situationOf({ ...missing, samples: 9 }, [], null)).toBe("unplugged");
    expect(situationOf(missing, [], null, "/dev/ttyUSB0")).toBe("unplugged");
    expect(situationOf(missing, [], null, "/dev/ttyUSB1")).toBe("no-port");
  });
  it("while connecting knows nothing yet, whatever was before", () => {
    const before = state("off", { reason_code: "LinkLost" });
    expect(situationOf(before, [], "PortBusy", null, true)).toBe("opening");
    expect(situationOf(state("no-port", { port: "a" }), [], "PortBusy")).toBe("opening");
  });
});

it("guesses only among the likely", () => {
  expect(bestGuess([port("ttyS0", false)])).toBeNull();
  expect(bestGuess([port("a", true), port("b", true)])?.url).toBe("a");
});

it("the block has twelve pins, and the two that nobody confirmed are marked", () => {
  expect(PINS).toHaveLength(12);
  expect(PINS.filter((pin) => pin.confidence === "unconfirmed").map((pin) => pin.number)).toEqual([
    2, 11,
  ]);
  expect(PINS.filter((pin) => pin.plug !== null).map((pin) => pin.number)).toEqual([2, 11, 12]);
});

describe("the examination", () => {
  const text = { en: "", ru: "" };
  const step = (name: string, ok: boolean | null): DoctorStep => ({
    name,
    ok,
    title: text,
    detail: text,
    to_try: null,
  });
  const marks = (steps: DoctorStep[], running: boolean) =>
    markSteps(steps, running).map((it) => it.mark);

  it("draws what runs now and what is to come", () => {
    expect(marks([], true)).toEqual(["running", "todo", "todo", "todo", "todo", "todo", "todo"]);
    expect(marks([step("port", true)], true).slice(0, 3)).toEqual(["ok", "running", "todo"]);
  });
  it("says what was left out and what was not reached", () => {
    const steps = [step("port", true), step("echo", true), step("latency", null)];
    expect(marks(steps, true)).toEqual([
      "ok",
      "ok",
      "skipped",
      "unsure",
      "running",
      "todo",
      "todo",
    ]);
    const broken = [step("port", true), step("echo", false)];
    expect(marks(broken, false)).toEqual([
      "ok",
      "bad",
      "skipped",
      "skipped",
      "skipped",
      "skipped",
      "skipped",
    ]);
  });
  it("comes to a verdict", () => {
    const last = step("commands", true);
    expect(verdict([step("port", true), last])).toBe("well");
    expect(verdict([step("port", true), step("line", null), last])).toBe("works");
    expect(verdict([step("line", null), step("ecu", false)])).toBe("broken");
  });
  it("says no more of one that was stopped than that", () => {
    expect(verdict([step("port", true), step("echo", true)])).toBe("stopped");
  });
});
