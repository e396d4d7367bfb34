import { expect, it } from "vitest";
import { parsed } from "./router.svelte";

it("an address names a screen, whatever stands in it", () => {
  expect(parsed("#/report/a%20b.pcapng")).toEqual(["report", "a b.pcapng"]);
  expect(["", "#", "#/nowhere/x", "#/chart//table"].map(parsed)).toEqual([["live"], ["live"], ["live", "x"], ["chart", "table"]]);
  expect(parsed("#/report/100%")).toEqual(["report", "100%"]);
});
