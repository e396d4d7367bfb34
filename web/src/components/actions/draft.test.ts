import { expect, it } from "vitest";
import type { ActionRule } from "../../lib/api/types";
import { doneBy, draftOf, ruleOf, wrongSeconds } from "./draft";

const RULE: ActionRule = {
  ...{ name: "hot", when: "TWAT > 105", hold: 2.5, until: "TWAT < 100", again: 60, once: true },
  ...{ mark: { en: "hot", ru: "горячо" }, record: "start", sound: true, speak: { en: "hot", ru: "hot" }, mqtt: false, webhook: "" },
};

it("a rule that was not touched stays as it was, in both languages", () => {
  expect(ruleOf(draftOf(RULE), RULE)).toEqual(RULE);
});

it("a text with two languages changes in the one that is shown; another one in both", () => {
  const rule = ruleOf({ ...draftOf(RULE), mark: "boiling", speak: "boiling" }, RULE);
  expect(rule.mark).toEqual({ en: "boiling", ru: "горячо" });
  expect(rule.speak).toEqual({ en: "boiling", ru: "boiling" });
});

it("empty fields are no action and no time", () => {
  const rule = ruleOf({ ...draftOf(RULE), mark: " ", speak: "", hold: "", again: "", record: "", sound: false }, RULE);
  expect([rule.mark, rule.speak, rule.record, rule.hold, rule.again]).toEqual([null, null, null, 0, 0]);
  expect(doneBy(rule)).toEqual([]);
  expect(doneBy(RULE)).toEqual(["mark", "record_start", "sound", "speak"]);
});

it("seconds are numbers, with a comma too, and not negative", () => {
  const draft = draftOf(RULE);
  expect([draft.hold, "0,5", "", "x", "-1"].map((hold) => wrongSeconds({ ...draft, hold }))).toEqual([
    undefined,
    undefined,
    undefined,
    "x",
    "-1",
  ]);
});
