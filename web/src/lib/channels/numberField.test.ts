import { expect, it } from "vitest";
import { parsedNumber } from "./numberField";

it("parsedNumber takes a comma and both minus signs, and tells empty from wrong", () => {
  expect(["1,5", "−2", " 3. ", ".5", "1e3", ""].map(parsedNumber)).toEqual([1.5, -2, 3, 0.5, 1000, null]);
  expect(["x", "1 2", "1,2,3", "--1", "1e999", "0x1"].map(parsedNumber)).toEqual(Array(6).fill(undefined));
});
