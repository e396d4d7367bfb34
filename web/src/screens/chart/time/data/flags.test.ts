import { describe, expect, it } from "vitest";
import type { LineEvent } from "../../../../lib/api/types";
import { flagsOf, wrapText, gapFlags, gapsOf, shiftedBy, nextGap } from "./flags";

const marker = (time: number, label = ""): LineEvent => ({ kind: "marker", time, label });
const text = { en: "x", ru: "х" };
const gap = (began: number, ended: number | null): LineEvent => ({ kind: "gap", time: ended ?? began, began, ended, reason: text });

describe("flags", () => {
  it("are the markers and alarms of the window, close ones merged", () => {
    const alarm = {
      kind: "alarm",
      time: 12,
      name: "TWAT",
      level: "warning",
      before: "none",
      side: "high",
      value: 101,
      limit: 100,
      text,
    } as const;
    const over = { ...alarm, time: 13, level: "none" } as const;
    const flags = flagsOf([marker(1), marker(10, "a"), marker(10.4, "b"), alarm, over, marker(30)], 5, 20, 1);
    expect(flags.map(({ kind, time, count }) => [kind, time, count])).toEqual([
      ["marker", 10, 2],
      ["warning", 12, 1],
    ]);
  });
});

describe("flags of one moment", () => {
  it("are merged by kind", () => {
    const alarm = (level: "warning" | "danger", name: string): LineEvent => ({
      kind: "alarm",
      time: 12,
      name,
      level,
      before: "none",
      side: "high",
      value: 1,
      limit: 0,
      text,
    });
    const flags = flagsOf([alarm("warning", "A"), alarm("danger", "B"), alarm("warning", "C")], 5, 20, 1);
    expect(flags.map(({ kind, count }) => [kind, count])).toEqual([
      ["warning", 2],
      ["danger", 1],
    ]);
  });
});

describe("gaps", () => {
  it("overlap the window, and last until now while open", () => {
    const bands = gapsOf([gap(1, 2), gap(4, 6), gap(8, null)], 5, 20, 9);
    expect(bands.map(({ from, to }) => [from, to])).toEqual([
      [4, 6],
      [8, 9],
    ]);
  });

  it("have the state of the line as their short reason", () => {
    const silent = { en: "echo, but the ECU is silent", ru: "эхо есть, блок молчит" };
    const state: LineEvent = { kind: "state", time: 5, state: "echo-only", text: silent, reason: text, code: null };
    expect(gapsOf([gap(4, 6), state], 0, 20, 9)[0]!.reason).toEqual(silent);
    expect(gapsOf([gap(7, 8), state], 0, 20, 9)[0]!.reason).toEqual(text);
  });

  it("keep their full reason", () => {
    const state: LineEvent = { kind: "state", time: 5, state: "echo-only", text: { en: "silent", ru: "молчит" }, reason: text, code: null };
    expect(gapsOf([gap(4, 6), state], 0, 20, 9)[0]!.whole).toEqual(text);
  });

  it("are flags, close ones merged, with a time inside for the cursor", () => {
    const flags = gapFlags(gapsOf([gap(4, 6), gap(7, 7.2), gap(7.3, 7.4), gap(12, 40)], 5, 20, 50), 5, 20, 1);
    expect(flags.map(({ time, at, count }) => [time, at, count])).toEqual([
      [5, 5.5, 1],
      [7, 7.1, 2],
      [12, 16, 1],
    ]);
  });

  it("are visited in order, with the second recording's, and wrap around", () => {
    const bands = [...gapsOf([gap(1, 3), gap(8, 10)], 0, 20, 20), ...shiftedBy(gapsOf([gap(101, 103)], 0, 200, 200), -97)];
    const after = (time: number) => nextGap(bands, time, 1)!.from;
    expect([after(0), after(2), after(5), after(9)]).toEqual([1, 4, 8, 1]);
    expect([nextGap(bands, 9, -1)!.from, nextGap(bands, 2, -1)!.from]).toEqual([4, 8]);
    expect(nextGap(bands, 2, 1)!.second).toBe(true);
    expect(nextGap([], 2, 1)).toBeUndefined();
  });

  it("wrap their reason into lines that fit, ended by an ellipsis", () => {
    const fits = (words: string) => words.length <= 9;
    expect(wrapText("echo, but the ECU is silent", fits, 3)).toEqual(["echo, but", "the ECU", "is silent"]);
    expect(wrapText("echo, but the ECU is silent", fits, 2)).toEqual(["echo, but", "the ECU…"]);
    expect(wrapText("disconnected", fits, 2)).toEqual(["disconne…"]);
  });
});
