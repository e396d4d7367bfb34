import { describe, expect, it } from "vitest";
import type { Port, State } from "../../lib/api/types";
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

describe("situationOf", () => {
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
  it("reports that there is no adapter", () => {
    expect(situationOf(state("off"), [], null)).toBe("no-cable");
    expect(situationOf(state("off"), [port("ttyS0", false)], null)).toBe("no-cable");
    expect(situationOf(state("off"), [port("a", true)], null)).toBe("off");
    expect(situationOf(state("off"), [port("ttyS0", false)], "NoPortGiven")).toBe("no-cable");
    expect(situationOf(state("off"), [port("a", true), port("b", true)], "NoPortGiven")).toBe(
      "several",
    );
  });
  it("recognizes an ELM327 by the server's error", () => {
    const reason = { reason_code: "NotAKLineAdapter" };
    expect(situationOf(state("no-echo", reason), [], null)).toBe("elm327");
    expect(situationOf(state("off", reason), [], null)).toBe("elm327");
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
  ] as const)("%s, %s", (url, reason_code, wanted) => {
    expect(situationOf(state("no-port", { port: url, reason_code }), [], null)).toBe(wanted);
  });
  it("reports an adapter as unplugged only if it was there", () => {
    const missing = state("no-port", { port: "/dev/ttyUSB0", reason_code: "PortNotFound" });
    expect(situationOf({ ...missing, samples: 9 }, [], null)).toBe("unplugged");
    expect(situationOf(missing, [], null, "/dev/ttyUSB0")).toBe("unplugged");
    expect(situationOf(missing, [], null, "/dev/ttyUSB1")).toBe("no-port");
  });
  it("is opening while connecting", () => {
    const before = state("off", { reason_code: "LinkLost" });
    expect(situationOf(before, [], "PortBusy", null, true)).toBe("opening");
    expect(situationOf(state("no-port", { port: "a" }), [], "PortBusy")).toBe("opening");
  });
});

it("bestGuess returns a likely port only", () => {
  expect(bestGuess([port("ttyS0", false)])).toBeNull();
  expect(bestGuess([port("a", true), port("b", true)])?.url).toBe("a");
});
