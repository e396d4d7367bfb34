import { describe, expect, it } from "vitest";
import { judge } from "./fresh";
import { joined } from "./live.svelte";
import type { LineEvent } from "./types";

const reason = { en: "no answer", ru: "нет ответа" };
const gap = (began: number, ended: number | null): LineEvent => ({ kind: "gap", time: ended ?? began, began, ended, reason });
const marker = (time: number): LineEvent => ({ kind: "marker", time, label: "" });

describe("events", () => {
  it("come in order, each once, however often they are told", () => {
    expect(joined([marker(1), marker(5)], [marker(5), marker(3)]).map(({ time }) => time)).toEqual([1, 3, 5]);
  });

  it("a gap that has ended replaces its beginning, and is not reopened by the past", () => {
    const after = joined([gap(2, null)], [gap(2, 4)]);
    expect(after).toEqual([gap(2, 4)]);
    expect(joined(after, [gap(2, null)])).toEqual([gap(2, 4)]);
  });
});

describe("freshness", () => {
  const latest = { value: 7, time: 100 };

  it("is three periods, at least a second", () => {
    expect(judge(latest, 100.9, 0.03).kind).toBe("fresh");
    expect(judge(latest, 101.5, 0.03)).toEqual({ kind: "stale", value: 7, age: 1.5 });
    expect(judge(latest, 105, 2).kind).toBe("fresh");
  });

  it("ends in nothing: never the last number", () => {
    expect(judge(latest, 111, 0.03)).toEqual({ kind: "none" });
    expect(judge(undefined, 111, 1)).toEqual({ kind: "none" });
  });
});
