import { describe, expect, it } from "vitest";
import { completed, completions, type Candidate } from "./completion";

const candidates: Candidate[] = [
  { name: "FREQ", about: "Обороты двигателя", kind: "channel" },
  { name: "JAIR", about: "Mass air flow", kind: "channel" },
  { name: "FUEL_FLOW", about: "Fuel", kind: "channel" },
  { name: "full", about: "385", kind: "constant" },
  { name: "sqrt", about: "root", kind: "function" },
];
const names = (formula: string, caret = formula.length) => completions(formula, caret, candidates).map(({ name }) => name);

describe("completions", () => {
  it("begin with what stands before the caret, or contain it", () => {
    expect(names("2 * f")).toEqual(["FREQ", "FUEL_FLOW", "full"]);
    expect(names("fl")).toEqual(["FUEL_FLOW", "JAIR"]);
    expect(names("обор")).toEqual(["FREQ"]);
    expect(names("2 * ")).toEqual([]);
    expect(names("12")).toEqual([]);
    expect(names("FREQ")).toEqual([]);
  });

  it("replace the whole name, and put the caret into a function's brackets", () => {
    const [found] = completions("1 + FRxx / 2", 6, candidates);
    expect(completed("1 + FRxx / 2", found!)).toEqual({ formula: "1 + FREQ / 2", caret: 8 });
    const [root] = completions("sq", 2, candidates);
    expect(completed("sq", root!)).toEqual({ formula: "sqrt()", caret: 5 });
    const [again] = completions("sq(2)", 2, candidates);
    expect(completed("sq(2)", again!)).toEqual({ formula: "sqrt(2)", caret: 5 });
  });
});
