import { describe, expect, it } from "vitest";
import type { Fault } from "../../lib/api/types";
import { changeText, codesOf, mergeEntries, parameterOf, valueOf } from "./journal";
import { faultsText, type Labels } from "./message";

const fault = (code: number, text: string): Fault => ({
  code,
  text: { en: text, ru: "" },
  confidence: text ? "confirmed" : "unknown",
  certain: Boolean(text),
  informational: false,
  check: text ? { en: "the plug", ru: "" } : null,
  related: ["JAIR"],
  first_seen: 0,
});
const words: Labels = {
  title: "Faults",
  none: "none",
  unknown: "not known",
  check: "check",
  now: "now",
  sure: (confidence) => confidence,
  text: (it) => it.text.en,
  check_text: (it) => it.check?.en ?? "",
  reading: (name) => (name === "JAIR" ? "JAIR 15.1 kg/h" : null),
};

describe("the text to send", () => {
  it("names every fault, known or not", () => {
    const text = faultsText(
      { time: 0, count: 2, faults: [fault(13, "Air mass low"), fault(99, "")] },
      ["Mikas 7.1"],
      words,
    );
    expect(text).toBe(
      "Faults\nMikas 7.1\n\n13: Air mass low (confirmed)\n   check: the plug\n   now: JAIR 15.1 kg/h\n" +
        "99: not known (unknown)\n   now: JAIR 15.1 kg/h\n",
    );
  });
  it("says so if there are none", () => {
    expect(faultsText({ time: 0, count: 0, faults: [] }, [], words)).toBe("Faults\n\nnone\n");
  });
});

describe("the journal", () => {
  const begun = {
    time: 1,
    change: "erase 2 stored fault(s)",
    command: "CWRITP",
    state: "started",
    before: "0D 35",
  };
  it("has one line for a change and its outcome", () => {
    const done = { ...begun, time: 2, state: "done", outcome: "" };
    const lines = mergeEntries([done, begun]);
    expect(lines).toHaveLength(1);
    expect(lines[0]).toMatchObject({ time: 2, state: "done", erase: true, codes: [13, 53] });
  });
  it("keeps a change whose outcome nobody saw", () => {
    const done = { ...begun, time: 2, state: "done" };
    const lines = mergeEntries([{ ...begun, time: 3 }, done, begun]);
    expect(lines.map((line) => [line.time, line.state])).toEqual([
      [3, "started"],
      [2, "done"],
    ]);
  });
  it("pairs each beginning with one end only", () => {
    const done = { ...begun, time: 4, state: "done" };
    expect(
      mergeEntries([done, { ...begun, time: 3 }, { ...begun, time: 1 }]).map((line) => line.time),
    ).toEqual([4, 1]);
  });
  it("is read in Russian too, and what is not known as it is", () => {
    expect(changeText("write 2 byte(s) to ram 0042").ru).toBe("записать байтов: 2, ram 0042");
    expect(changeText("set the unit's list to 21 code(s)").ru).toBe(
      "задать список блока, кодов: 21",
    );
    expect(changeText("dance").ru).toBe("dance");
    expect(changeText({ en: "a", ru: "б" })).toEqual({ en: "a", ru: "б" });
  });
  it("reads codes in any of their forms", () => {
    expect(codesOf("0D 35")).toEqual([13, 53]);
    expect(codesOf("0D35")).toEqual([13, 53]);
    expect(codesOf([13, { code: 53 }, {}])).toEqual([13, 53]);
    expect(codesOf(null)).toEqual([]);
  });
});

describe("a parameter that was written", () => {
  const volts = { formula: "b / 10", size: 1, flag: false };

  it("is named by the change", () => {
    expect(parameterOf({ en: "write parameter RCOD", ru: "записать параметр RCOD" })).toBe("RCOD");
    expect(parameterOf("erase 2 stored fault(s)")).toBeNull();
  });

  it("has the value that its formula makes of the bytes", () => {
    expect(valueOf("8A", volts)).toBeCloseTo(13.8);
    expect(valueOf("DC05", { formula: "w / 100", size: 2, flag: false })).toBe(15);
    expect(valueOf("DC 05", { formula: "w / 100", size: 2, flag: false })).toBe(15);
  });

  it("has none where there are no bytes of its size, or it is a flag", () => {
    expect([null, "8A05", "refused", 138].map((it) => valueOf(it, volts))).toEqual([null, null, null, null]);
    expect(valueOf("40", { formula: "b & 0x40", size: 1, flag: true })).toBeNull();
  });
});
