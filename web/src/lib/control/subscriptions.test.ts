import { afterEach, beforeEach, describe, expect, it, vi, type MockInstance } from "vitest";
import { isSame, planWith, supportedNames } from "./subscriptions.svelte";
import type { Catalog, State } from "../api/types";
import { served } from "../platform/host";
import { Stores } from "../../stores";

const { api, catalog, live, subscriptions } = new Stores(served);

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

describe("a selection beside another page", () => {
  const free = { line: "sampling", viewers: 2, catalog: "2", rights: "control", controller: null, dropped_parameters: [] };
  const now = (change: Partial<State> = {}): State =>
    ({ ...free, plan: { wanted: [{ name: "UGB" }, { name: "TWAT" }], first: ["UGB"] }, ...change }) as unknown as State;
  const loaded = (version: string): Catalog =>
    ({ version, parameters: [{ name: "UGB" }, { name: "TWAT" }], derived: [], presets: [] }) as unknown as Catalog;
  let first: MockInstance<typeof api.first>;

  beforeEach(() => {
    first = vi.spyOn(api, "first").mockResolvedValue(now());
    live.link = "open";
    live.state = now();
    catalog.loaded = loaded("2");
  });
  afterEach(() => {
    subscriptions.set("preset", [], false);
    live.link = "connecting";
    live.state = catalog.loaded = null;
  });

  it("is requested at once, and what the page shows by itself is not", () => {
    subscriptions.set("preset", ["TWAT"], false);
    expect(first).not.toHaveBeenCalled();
    subscriptions.set("preset", ["TWAT"], true);
    expect(first.mock.calls).toEqual([[["TWAT"]]]);
  });

  it.each<[string, () => unknown, () => unknown]>([
    ["the connection", () => (live.link = "lost"), () => (live.link = "open")],
    ["the state", () => (live.state = null), () => (live.state = now())],
    ["the catalog", () => (catalog.loaded = null), () => (catalog.loaded = loaded("2"))],
    ["the catalog of the state", () => (catalog.loaded = loaded("1")), () => (catalog.loaded = loaded("2"))],
  ])("waits for %s, and is requested once", (_, before, after) => {
    before();
    subscriptions.set("preset", ["TWAT"], true);
    subscriptions.set("preset", ["TWAT"], false); // the screen shows it
    subscriptions.refresh();
    expect(first).not.toHaveBeenCalled();
    after();
    subscriptions.refresh();
    subscriptions.refresh();
    expect(first.mock.calls).toEqual([[["TWAT"]]]);
  });

  it("does not wait for another client to give control back", () => {
    live.state = now({ controller: { you: false } as State["controller"] });
    subscriptions.set("preset", ["TWAT"], true);
    live.state = now();
    subscriptions.refresh();
    expect(first).not.toHaveBeenCalled();
  });
});
