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
