import { expect, it } from "vitest";
import { LIVE, sourceOf } from "./source";

it("the source is the one in the address, or else the open recording", () => {
  expect(sourceOf(undefined, null)).toBe(null);
  expect(sourceOf(undefined, "a.pcapng")).toBe("a.pcapng");
  expect(sourceOf(LIVE, "a.pcapng")).toBe(null);
  expect(sourceOf("b.pcapng", "a.pcapng")).toBe("b.pcapng");
});
