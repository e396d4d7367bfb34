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
