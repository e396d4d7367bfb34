import { describe, expect, it } from "vitest";
import { supportedNames, planFor, alarmChannels, withAlarmChannels } from "./subscriptions.svelte";
import type { State } from "../api/types";

const state = (names: string[], recording = false): State =>
  ({
    plan: { wanted: names.map((name) => ({ name, every: name === "TWAT" ? 10 : 1 })), method: "auto", rate: null },
    recording: recording ? {} : null,
  }) as unknown as State;

const limits = { danger_low: null, warning_low: null, warning_high: 100, danger_high: null };

describe("planFor", () => {
  it("contains the shown channels and keeps their divisors", () => {
    expect(planFor(["FREQ", "TWAT"], [], state(["TWAT", "UOZ"]))).toEqual([
      { name: "FREQ", every: 1 },
      { name: "TWAT", every: 10 },
    ]);
  });

  it("is null when the current plan has the same channels in any order", () => {
    expect(planFor(["FREQ", "UOZ"], [], state(["UOZ", "FREQ"]))).toBeNull();
  });

  it("removes no channel while recording", () => {
    expect(planFor(["FREQ"], [], state(["UOZ", "INJ"], true))?.map(({ name }) => name)).toEqual(["FREQ", "UOZ", "INJ"]);
    expect(planFor(["UOZ"], [], state(["UOZ", "INJ"], true))).toBeNull();
  });

  it("samples alarm channels that are not shown at a low rate", () => {
    const passing = planFor(["FREQ"], ["TWAT"], state(["FREQ"]))!;
    expect(passing.map(({ name }) => name)).toEqual(["FREQ", "TWAT"]);
    expect(passing[1]!.every).toBeGreaterThanOrEqual(10);
    const asked = { plan: { wanted: passing, method: "auto" as const, rate: null }, recording: null };
    expect(planFor(["FREQ"], ["TWAT"], asked)).toBeNull();
    // On the screen it is sampled at its own rate, off the screen at the low rate of alarms again.
    const shown = planFor(["FREQ", "TWAT"], ["TWAT"], asked)!;
    expect(shown).toEqual([{ name: "FREQ", every: 1 }, { name: "TWAT", every: 1 }]);
    expect(planFor(["FREQ"], ["TWAT"], { ...asked, plan: { ...asked.plan, wanted: shown } })).toEqual(passing);
  });

  it("slows no channel while recording", () => {
    expect(planFor(["FREQ"], ["UACC"], state(["FREQ", "UACC"], true))).toBeNull();
  });
});

it("channels with limits and flags that raise an alarm are alarm channels", () => {
  const channel = (name: string, own: object) => ({ name, limits: null, alarm_when_true: "none" as const, ...own });
  expect(alarmChannels([channel("FREQ", {}), channel("TWAT", { limits }), channel("RDET", { alarm_when_true: "warning" })])).toEqual(["TWAT", "RDET"]);
  expect(withAlarmChannels([{ name: "TWAT", every: 1 }], ["TWAT"])).toEqual([{ name: "TWAT", every: 1 }]);
});

it("supportedNames leaves out unsupported channels", () => {
  expect(supportedNames([{ name: "FREQ" }, { name: "UOZ" }], { dropped_parameters: ["UOZ"] })).toEqual(["FREQ"]);
});
