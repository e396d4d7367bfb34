import { expect, it, vi } from "vitest";
import { Route, parsed } from "./router.svelte";

it("an address names a screen, whatever stands in it", () => {
  expect(parsed("#/report/a%20b.pcapng")).toEqual(["report", "a b.pcapng"]);
  expect(["", "#", "#/nowhere/x", "#/chart//table"].map(parsed)).toEqual([["live"], ["live"], ["live", "x"], ["chart", "table"]]);
  expect(parsed("#/report/100%")).toEqual(["report", "100%"]);
});

it("what took a while leads nowhere once the person has gone elsewhere", () => {
  const route = new Route();
  const went = vi.spyOn(route, "go").mockReturnValue();
  route.later()("live");
  expect(went).toHaveBeenCalledExactlyOnceWith("live");
  const late = route.later();
  route.rest = []; // as each new address does
  late("live");
  expect(went).toHaveBeenCalledOnce();
});
