import { describe, expect, it } from "vitest";
import { leastOf, readChoice } from "./choice.svelte";

describe("the choice", () => {
  it("is read from what this browser stored, with defaults for what is missing or not valid", () => {
    const first = readChoice(null);
    expect(readChoice("{")).toEqual(first);
    expect(readChoice("null")).toEqual(first);
    const stored = {
      scatter: { x: "THR", y: 5 },
      statistic: "mode",
      least: 0,
      age: 0.2,
      edges: { FREQ: [0, 1, 2], THR: [2, 1], INJ: "x", UOZ: Array.from({ length: 500 }, (_, at) => at) },
    };
    expect(readChoice(JSON.stringify(stored))).toEqual({
      ...first,
      scatter: { ...first.scatter, x: "THR" },
      age: 0.2,
      edges: { FREQ: [0, 1, 2] },
    });
  });

  it("has a whole least count of at least 1", () => {
    expect(["5", "1", "0", "", "2.5", "x", "-1", "1000000"].map(leastOf)).toEqual([5, 1, null, null, null, null, null, null]);
  });
});
