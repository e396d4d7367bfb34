import { describe, expect, it } from "vitest";
import { isSame, planWith, supportedNames } from "./subscriptions.svelte";
import type { State } from "../api/types";

const state = (names: string[]): State =>
  ({ plan: { wanted: names.map((name) => ({ name, every: name === "TWAT" ? 10 : 1, cycles: 5 })) } }) as unknown as State;

describe("planWith", () => {
  it("is null when every channel is sampled", () => {
    expect(planWith(["FREQ", "UOZ"], state(["UOZ", "INJ", "FREQ"]))).toBeNull();
  });

  it("removes no channel and keeps the requested divisors", () => {
    expect(planWith(["FREQ"], state(["TWAT", "UOZ"]))).toEqual([
      { name: "TWAT", every: 10 },
      { name: "UOZ", every: 1 },
      { name: "FREQ", every: 1 },
    ]);
  });
});

it("isSame compares names in any order", () => {
  expect(isSame(["FREQ", "UOZ"], ["UOZ", "FREQ"])).toBe(true);
  expect([isSame(["FREQ"], ["UOZ"]), isSame([], ["UOZ"]), isSame(["UOZ", "FREQ"], ["UOZ"])]).toEqual([false, false, false]);
});

it("supportedNames leaves out unsupported channels", () => {
  expect(supportedNames([{ name: "FREQ" }, { name: "UOZ" }], { dropped_parameters: ["UOZ"] })).toEqual(["FREQ"]);
});
