import { expect, it } from "vitest";
import { PINS } from "./diagnosticBlock";

it("the block has twelve pins, two of them unconfirmed", () => {
  expect(PINS).toHaveLength(12);
  expect(PINS.filter((pin) => pin.confidence === "unconfirmed").map((pin) => pin.number)).toEqual([2, 11]);
  expect(PINS.filter((pin) => pin.plug !== null).map((pin) => pin.number)).toEqual([2, 11, 12]);
});
