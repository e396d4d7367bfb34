import { describe, expect, it } from "vitest";
import { fileName, sheetText } from "./sheet";

describe("the passport sheet", () => {
  it("has aligned columns", () => {
    expect(
      sheetText("T", [
        ["a", "1"],
        ["long", "2"],
      ]),
    ).toBe("T\n\na     1\nlong  2\n");
  });
  it("has a file name without special characters", () => {
    expect(fileName(["Mikas 7.1", null, "  ", "А/Б:1"], "json")).toBe("Mikas-7.1-А-Б-1.json");
    expect(fileName([null], "txt")).toBe("mikas.txt");
  });
});
