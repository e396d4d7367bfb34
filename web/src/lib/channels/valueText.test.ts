import { expect, it } from "vitest";
import type { Channel } from "../api/types";
import { valueText, valueWithUnit, wordsOf } from "./valueText";

const channel = (given: object) => ({ decimals: 1, flag: false, unit: { en: "V", ru: "В" }, ...given }) as Channel;
const lamp = { on: { en: "Knock", ru: "" }, off: { en: "No knock", ru: "" } };

it("a value is a number with its unit, or a word of a flag", () => {
  expect([valueText(channel({}), 13.84), valueWithUnit(channel({}), 13.84)]).toEqual(["13.8", "13.8 V"]);
  expect([0, 1].map((value) => valueWithUnit(channel({ flag: true, lamp }), value))).toEqual(["No knock", "Knock"]);
  // Of the user's own catalog, without words.
  expect([0, 1].map((value) => valueWithUnit(channel({ flag: true, lamp: null }), value))).toEqual(["off", "on"]);
  expect([channel({}), channel({ flag: true, lamp }), undefined].map((it) => valueWithUnit(it, null))).toEqual(["–", "–", "–"]);
  expect([wordsOf(channel({})), wordsOf(undefined)]).toEqual([[], []]);
});
