import { afterEach, expect, it } from "vitest";
import { language } from "./language.svelte";
import { fieldText, parsedNumber } from "./formats";

afterEach(() => {
  language.code = "en";
});

it("parsedNumber takes a comma and both minus signs, and tells empty from wrong", () => {
  expect(["1,5", "−2", " 3. ", ".5", "1e3", ""].map(parsedNumber)).toEqual([1.5, -2, 3, 0.5, 1000, null]);
  expect(["x", "1 2", "1,2,3", "--1", "1e999", "0x1"].map(parsedNumber)).toEqual(Array(6).fill(undefined));
});

it("fieldText keeps every digit of a number", () => {
  const numbers = [0, 100, -1.5, 0.00025, 3.26e-10, 1e21, 123456.789012];
  for (const code of ["en", "ru"] as const) {
    language.code = code;
    expect(numbers.map(fieldText).map(parsedNumber)).toEqual(numbers);
  }
  expect(fieldText(-0.00025)).toBe("−0,00025");
});
