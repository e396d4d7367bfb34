import { expect, it } from "vitest";
import type { WritableParameter } from "../../lib/api/types";
import { digitsOf, fits, moved } from "./steps";

const bytes = (lowest: number, highest: number, step: number) => ({ lowest, highest, step }) as WritableParameter;

it("as many digits as distinguish two neighbours", () => {
  expect([1, 0.5, 0.01, 0.25, 1 / 256, 1 / 125, 2].map(digitsOf)).toEqual([0, 1, 2, 2, 4, 3, 0]);
});

it("steps go from one value of the bytes to the next, and end at the last", () => {
  const quarter = bytes(-10, 53.75, 0.25);
  expect([moved(0, 1, quarter), moved(0.1, 1, quarter), moved(-10, -1, quarter), moved(53, 10, quarter)]).toEqual([0.25, 0.25, -10, 53.75]);
  expect(moved(5, 1, { lowest: null, highest: null, step: null } as WritableParameter)).toBe(5);
});

it("what the nearest bytes hold fits", () => {
  const byte = bytes(0, 255, 1);
  expect([-0.4, 0, 255, 255.4, 255.5, -0.6, NaN].map((value) => fits(value, byte))).toEqual([true, true, true, true, false, false, false]);
});
