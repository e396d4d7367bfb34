import { expect, it, vi } from "vitest";
import type { LineEvent } from "../api/types";
import { served } from "../platform/host";
import { Stores } from "../../stores";
import { actionTeller } from "./actionNews";

const words = (text: string) => ({ en: text, ru: text });
const action = (time: number, more: object = {}): LineEvent => ({
  ...{ kind: "action" as const, time, name: "hot", text: words(`acted ${time}`), sound: false, speak: null, failed: false },
  ...more,
});

function told() {
  const stores = new Stores(served);
  vi.spyOn(stores.live, "now").mockReturnValue(100);
  const ring = vi.spyOn(stores.pageActions, "ring").mockReturnValue();
  const say = vi.spyOn(stores.pageActions, "say").mockReturnValue();
  return { tell: actionTeller(stores), ring, say, shown: () => stores.toasts.shown.map(({ text }) => text()) };
}

it("what an action does on a page is done once, in whatever order events come", () => {
  const { tell, ring, say, shown } = told();
  const first = action(98, { sound: true, speak: words("hot") });
  tell([first]);
  tell([action(97), first, { kind: "marker", time: 99, label: "" }]);
  tell([action(97), first]);
  expect(shown()).toEqual(["acted 98", "acted 97"]);
  expect(ring).toHaveBeenCalledOnce();
  expect(say.mock.calls).toEqual([[words("hot")]]);
});

it("what was done before this page was opened is no news", () => {
  const { tell, shown } = told();
  tell([action(80)]);
  expect(shown()).toEqual([]);
});

it("a failure is shown as one", () => {
  const stores = new Stores(served);
  vi.spyOn(stores.live, "now").mockReturnValue(100);
  const error = vi.spyOn(stores.toasts, "error");
  actionTeller(stores)([action(99, { failed: true, name: "", text: words("no broker") })]);
  expect(error).toHaveBeenCalledOnce();
});
