import { expect, it } from "vitest";
import { excerpt } from "./excerpt";

const around = (formula: string, wrong: string) => {
  const at = formula.indexOf(wrong);
  const found = excerpt(formula, [at, at + wrong.length]);
  return found && [found.before, found.wrong, found.after];
};

it("keeps the first letter of a formula, wherever the wrong part is", () => {
  for (let spaces = 1; spaces < 40; spaces += 1) {
    const [before] = around(`FREQ ${"+ 1 ".repeat(spaces)}> LOD`, "LOD")!;
    expect(before).toMatch(/^(FREQ|…[+1>])/);
  }
  expect(around("FREQ > 3000 and LOAD > 1", "LOAD")).toEqual(["FREQ > 3000 and ", "LOAD", " > 1"]);
  expect(around("FREQ * 1000 / 1.5 and LOD", "LOD")).toEqual(["FREQ * 1000 / 1.5 and ", "LOD", ""]);
});

it("cuts between words, and says so", () => {
  const long = "THROTTLE_POSITION > 20 and ENGINE_SPEED > 1000 and LOD and BATTERY_VOLTAGE > 12 and X";
  expect(around(long, "LOD")).toEqual(["…ENGINE_SPEED > 1000 and ", "LOD", " and BATTERY_VOLTAGE…"]);
});

it("has nothing to show of a problem without a place", () => {
  expect([excerpt("FREQ", null), excerpt("FREQ +", [6, 7]), excerpt("FREQ  ", [4, 6])]).toEqual([null, null, null]);
});
