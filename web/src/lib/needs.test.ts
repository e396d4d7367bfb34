import { describe, expect, it } from "vitest";
import { everyName, planFor } from "./needs.svelte";
import type { State } from "./types";

const state = (names: string[], recording = false): State =>
  ({
    plan: { wanted: names.map((name) => ({ name, every: name === "TWAT" ? 10 : 1 })), method: "auto", rate: null },
    recording: recording ? {} : null,
  }) as unknown as State;

describe("the plan to ask for", () => {
  it("is what is shown, and how often stays as it was", () => {
    expect(planFor(["FREQ", "TWAT"], state(["TWAT", "UOZ"]))).toEqual([
      { name: "FREQ", every: 1 },
      { name: "TWAT", every: 10 },
    ]);
  });

  it("is left alone when it does already, in whatever order", () => {
    expect(planFor(["FREQ", "UOZ"], state(["UOZ", "FREQ"]))).toBeNull();
  });

  it("takes nothing away from a recording", () => {
    expect(planFor(["FREQ"], state(["UOZ", "INJ"], true))?.map(({ name }) => name)).toEqual(["FREQ", "UOZ", "INJ"]);
    expect(planFor(["UOZ"], state(["UOZ", "INJ"], true))).toBeNull();
  });
});

it("everything is all that the unit does not refuse", () => {
  expect(everyName([{ name: "FREQ" }, { name: "UOZ" }], { dropped_parameters: ["UOZ"] })).toEqual(["FREQ"]);
});
