import { expect, it } from "vitest";
import { tabbed } from "./output";

it("a table for a spreadsheet has tabs between its cells, and none inside", () => {
  expect(
    tabbed([
      ["a\tb", 1.5],
      ["c\r\nd", ""],
    ]),
  ).toBe("a b\t1.5\nc d\t\n");
});

it("no cell is a formula in a spreadsheet, and a number stays one", () => {
  expect(tabbed([["=cmd|' /C calc'!A0", " \uff1dx", "a;=x", "-5", "-1,5", "-", "a-b"]])).toBe(
    "'=cmd|' /C calc'!A0\t' \uff1dx\ta;'=x\t-5\t-1,5\t-\ta-b\n",
  );
});
