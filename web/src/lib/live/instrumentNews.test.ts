import { expect, it, vi } from "vitest";
import type { LineEvent } from "../api/types";
import { served } from "../platform/host";
import { Stores } from "../../stores";
import { instrumentTeller } from "./instrumentNews";

const words = (text: string) => ({ en: text, ru: text });
const change = (time: number, state: "connected" | "values" | "silent" | "lost", name = "aem"): LineEvent => ({
  ...{ kind: "instrument" as const, time, name, state, text: words(`${name} ${state}`), reason: null },
});

function told() {
  const stores = new Stores(served);
  vi.spyOn(stores.live, "now").mockReturnValue(100);
  return { tell: instrumentTeller(stores), shown: () => stores.toasts.shown.map(({ text }) => text()) };
}

it("a loss is shown until the instrument is there again", () => {
  const { tell, shown } = told();
  const lost = change(98, "lost");
  tell([change(97, "values"), lost]);
  tell([change(97, "values"), lost, { kind: "marker", time: 99, label: "" }]);
  expect(shown()).toEqual(["aem lost"]);
  tell([lost, change(99, "connected")]);
  expect(shown()).toEqual([]);
});

it("of two instruments each has its own message, and only the last state of each counts", () => {
  const { tell, shown } = told();
  tell([change(96, "lost"), change(97, "silent", "nmea"), change(98, "values")]);
  expect(shown()).toEqual(["nmea silent"]);
});

it("what was before this page was opened is no news", () => {
  const { tell, shown } = told();
  tell([change(80, "lost")]);
  expect(shown()).toEqual([]);
});
