import { expect, it } from "vitest";
import { bandsOf } from "./valueRanges.svelte";

it("gives the lowest and the highest value of each channel, and none for one without values", () => {
  const bands = bandsOf({ names: ["FREQ", "TWAT", "JAIR"], values: [[840, null, 860, 850], [null, null], [14.5]] });
  expect([...bands]).toEqual([
    ["FREQ", [840, 860]],
    ["JAIR", [14.5, 14.5]],
  ]);
});
