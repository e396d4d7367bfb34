import { expect, it } from "vitest";
import type { LineEvent } from "../api/types";
import { faultNews } from "./faultNews";

const faults = (time: number, codes: number[], added: number[]): LineEvent => ({ kind: "faults", time, codes, added, erased: false });
const marker = { kind: "marker", time: 9, label: "" } as LineEvent;

it("names the faults that were not stored before", () => {
  expect(faultNews([faults(1, [53], [53]), faults(2, [53, 13], [13]), marker], 1)).toEqual({ time: 2, added: [13] });
});

it("is silent about faults that have gone, old events and none", () => {
  expect(faultNews([faults(1, [53, 13], [53, 13]), faults(2, [53], [])], 0)).toBeNull();
  expect(faultNews([faults(1, [53], [53])], 1)).toBeNull();
  expect(faultNews([marker], 0)).toBeNull();
});
