import { beforeEach, expect, it, vi } from "vitest";
import { served } from "../../../lib/platform/host";
import { saveSetting } from "../../../lib/platform/storage";
import { lying } from "../../../lib/platform/viewport";
import { Stores } from "../../../stores";

/** Big numbers on a page that is opened in this position. */
function opened(onItsSide: boolean) {
  vi.spyOn(lying, "current", "get").mockReturnValue(onItsSide);
  return new Stores(served).big;
}

beforeEach(() => {
  saveSetting("big", "");
  saveSetting("big-lying", "");
});

it("are what a phone on its side shows, and no other window", () => {
  expect(opened(true).on).toBe(true);
  expect(opened(false).on).toBe(false);
});

it("a person's choice wins, is kept, and is of the position in which it was made", () => {
  const big = opened(true);
  big.toggle();
  expect(big.on).toBe(false);
  expect([opened(true).on, opened(false).on]).toEqual([false, false]);
  opened(false).toggle();
  expect([opened(false).on, opened(true).on]).toEqual([true, false]);
  opened(true).toggle();
  expect(opened(true).on).toBe(true);
});
