import { describe, expect, it } from "vitest";
import { completed, completions, isWhole, inserts, type Candidate } from "./completion";

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

  it("are proposed by another name, which is whole by itself", () => {
    const known = [
      { name: "DUTY", about: "Load", kind: "channel" as const, also: ["скважность"] },
      { name: "FREQ", about: "Частота", kind: "channel" as const, also: ["rpm", "обороты"] },
    ];
    expect(completions("rpm > 3", 3, known).map(({ name, from, to }) => [name, from, to])).toEqual([["FREQ", 0, 3]]);
    expect(completions("Обор", 4, known).map(({ name }) => name)).toEqual(["FREQ"]);
    expect([isWhole("rpm", 3, known), isWhole("Обороты", 7, known), isWhole("обор", 4, known)]).toEqual([true, true, false]);
  });

  it("are not chosen unasked behind a whole name", () => {
    const known = [
      ...candidates,
      { name: "DET", about: "", kind: "channel" as const },
      { name: "RDET", about: "", kind: "channel" as const },
    ];
    expect(completions("not det", 7, known).map(({ name }) => name)).toEqual(["RDET"]);
    expect(isWhole("not det", 7, known)).toBe(true);
    expect(isWhole("not de", 6, known)).toBe(false);
    expect(isWhole("not ", 4, known)).toBe(false);
  });

  it("are inserted by Enter and Tab if one is chosen; Shift and Tab go back", () => {
    const by = (key: string, shiftKey: boolean, chosen: number) => inserts({ key, shiftKey }, 1, chosen);
    expect([by("Enter", false, 0), by("Tab", false, 0), by("Tab", true, 0), by("a", false, 0)]).toEqual([true, true, false, false]);
    // Behind DET, of RDET.
    expect([by("Enter", false, -1), by("Tab", false, -1)]).toEqual([false, false]);
    expect(inserts({ key: "Enter", shiftKey: false }, 0, 0)).toBe(false);
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
