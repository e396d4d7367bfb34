import { flushSync } from "svelte";
import { beforeEach, expect, it, vi } from "vitest";
import { eachOnItsOwnPage, page } from "../../../test/pageRig";
import ConnectionNotices from "./ConnectionNotices.svelte";
import { choice } from "./adapters.svelte";

eachOnItsOwnPage();
beforeEach(() => void vi.stubGlobal("isSecureContext", true));

it("the question for a cable that was not in the list ends when the unit answers", () => {
  choice.cancelled = true;
  const { say, show } = page();
  say({ line: "no-port" });
  show(ConnectionNotices, {});
  const asks = () => document.body.textContent.includes("was not in the list");
  expect(asks()).toBe(true);
  say({ line: "sampling" });
  flushSync();
  expect(asks()).toBe(false);
  say({ line: "no-port" });
  flushSync();
  expect(asks()).toBe(false);
});

it.each([
  ["a phone", "Mozilla/5.0 (Linux; Android 10; K)", "Some phones (Oppo"],
  ["a computer with Windows", "Mozilla/5.0 (Windows NT 10.0)", "Device Manager"],
])("on %s the question has the advice for it", (_, userAgent, advice) => {
  vi.spyOn(navigator, "userAgent", "get").mockReturnValue(userAgent);
  vi.stubGlobal("isSecureContext", true);
  Object.assign(navigator, { usb: new EventTarget(), serial: new EventTarget() });
  choice.cancelled = true;
  const { say, show } = page();
  say({ line: "no-port" });
  show(ConnectionNotices, {});
  expect(document.body.textContent).toContain(advice);
  Object.assign(navigator, { usb: undefined, serial: undefined });
  choice.cancelled = false;
});

it("what was chosen and is no cable is said, until the unit answers", () => {
  choice.unknown = true;
  const { say, show } = page();
  say({ line: "no-port" });
  show(ConnectionNotices, {});
  const asks = () => document.body.textContent.includes("no cable that is known");
  expect(asks()).toBe(true);
  say({ line: "sampling" });
  flushSync();
  expect(asks()).toBe(false);
});
