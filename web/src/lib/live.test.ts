import { describe, expect, it } from "vitest";
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
