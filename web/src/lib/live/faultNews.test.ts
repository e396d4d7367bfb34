import { expect, it } from "vitest";
import type { LineEvent } from "../api/types";
import { faultNews } from "./faultNews";

const faults = (time: number, codes: number[], added: number[]): LineEvent => ({ kind: "faults", time, codes, added, erased: false });
const marker = { kind: "marker", time: 9, label: "" } as LineEvent;

it("names the faults that were not stored before", () => {
  const [first, second] = [faults(1, [53], [53]), faults(2, [53, 13], [13])];
  expect(faultNews([first, second, marker], first)).toBe(second);
});

it("names those of another clock", () => {
  expect(faultNews([faults(5, [13], [13])], faults(1.8e9, [53], [53]))?.added).toEqual([13]);
});

it("is silent about faults that have gone, old events and none", () => {
  expect(faultNews([faults(1, [53, 13], [53, 13]), faults(2, [53], [])], null)).toBeNull();
  const seen = faults(1, [53], [53]);
  expect(faultNews([seen], seen)).toBeNull();
  expect(faultNews([marker], null)).toBeNull();
});
