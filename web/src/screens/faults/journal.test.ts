import { describe, expect, it } from "vitest";
import { changeText, codesOf, mergeEntries, parameterOf, valueOf } from "./journal";

const words = (en: string) => ({ en, ru: en });
const begun = { time: 1, change: words("erase 2 stored fault(s)"), command: "CWRITP", state: "started", before: "0D 35" } as const;

describe("mergeEntries", () => {
  it("merges a change and its result into one line", () => {
    const done = { ...begun, time: 2, state: "done", outcome: "" } as const;
    const lines = mergeEntries([done, begun]);
    expect(lines).toHaveLength(1);
    expect(lines[0]).toMatchObject({ time: 2, state: "done", codes: [13, 53] });
  });
  it("keeps a change without a result", () => {
    const done = { ...begun, time: 2, state: "done" } as const;
    const lines = mergeEntries([{ ...begun, time: 3 }, done, begun]);
    expect(lines.map((line) => [line.time, line.state])).toEqual([
      [3, "started"],
      [2, "done"],
    ]);
  });
  it("pairs each start with one end only", () => {
    const done = { ...begun, time: 4, state: "done" } as const;
    expect(mergeEntries([done, { ...begun, time: 3 }, { ...begun, time: 1 }]).map((line) => line.time)).toEqual([4, 1]);
  });
  it("translates known English entries", () => {
    expect(changeText(words("write 2 byte(s) to ram 0042")).ru).toBe("записать байтов: 2, ram 0042");
    expect(changeText(words("set the unit's list to 21 code(s)")).ru).toBe("задать список блока, кодов: 21");
    expect(changeText(words("dance")).ru).toBe("dance");
    expect(changeText({ en: "a", ru: "б" })).toEqual({ en: "a", ru: "б" });
  });
  it("reads codes in all forms", () => {
    expect(codesOf("0D 35")).toEqual([13, 53]);
    expect(codesOf("0D35")).toEqual([13, 53]);
    expect(codesOf(null)).toEqual([]);
  });
});

describe("a parameter that was written", () => {
  const volts = { formula: "b / 10", size: 1, flag: false };

  it("is found in the text of the change", () => {
    expect(parameterOf({ en: "write parameter RCOD", ru: "записать параметр RCOD" })).toBe("RCOD");
    expect(parameterOf(words("erase 2 stored fault(s)"))).toBeNull();
  });

  it("has the value of its formula", () => {
    expect(valueOf("8A", volts)).toBeCloseTo(13.8);
    expect(valueOf("DC05", { formula: "w / 100", size: 2, flag: false })).toBe(15);
    expect(valueOf("DC 05", { formula: "w / 100", size: 2, flag: false })).toBe(15);
  });

  it("has no value for other sizes and for flags", () => {
    expect(["8A05", "refused"].map((it) => valueOf(it, volts))).toEqual([null, null]);
    expect(valueOf("40", { formula: "b & 0x40", size: 1, flag: true })).toBeNull();
  });
});
