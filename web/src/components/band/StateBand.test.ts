import { fireEvent, screen } from "@testing-library/svelte";
import { flushSync } from "svelte";
import { expect, it, vi } from "vitest";
import type { State } from "../../lib/api/types";
import { channelOf, eachOnItsOwnPage, page } from "../../../test/pageRig";
import StateBand from "./StateBand.svelte";

eachOnItsOwnPage();
const text = () => document.body.textContent.replace(/\s+/g, " ");

function band(more: Partial<State> = {}) {
  const shown = page();
  shown.say(more);
  shown.stores.catalog.use({ version: "1", parameters: [channelOf("TWAT")], derived: [] } as never);
  shown.show(StateBand, { onhelp: () => undefined });
  return shown;
}

it("the line is in words, with the unit and its rate", () => {
  band();
  expect(text()).toContain("Sampling");
  expect(text()).toContain("Mikas 7.1");
  expect(text()).toContain("50 %");
});

it("a program that is gone is said, and its last figures are not", () => {
  vi.useFakeTimers();
  const { socket } = band();
  socket.onclose!.call({} as WebSocket, {} as CloseEvent);
  flushSync();
  expect(screen.getByRole("alert").textContent).toContain("has ended or can't be reached");
  expect(text()).not.toContain("Mikas 7.1");
  vi.useRealTimers();
});

it.each([
  ["a program that finds adapters", null, "Plug it back in and sampling resumes. For another"],
  ["a browser that lists them", async () => null, "if it does not, choose it again on Connection"],
])("an adapter that was unplugged has the advice for %s", (_, choosePort, advice) => {
  const shown = page();
  shown.stores.host.choosePort = choosePort;
  const reason = { en: "Port COM3 is not here", ru: "Порта COM3 нет" };
  shown.say({ line: "no-port", reason, reason_code: "PortNotFound", samples: 9 });
  shown.stores.catalog.use({ version: "1", parameters: [], derived: [] } as never);
  shown.show(StateBand, { onhelp: () => undefined });
  expect(text()).toContain(advice);
});

it("an alarm is a button that lists it", async () => {
  band({ alarms: [{ name: "TWAT", level: "danger", side: "high", value: 120, limit: 110, since: 90 }] as State["alarms"] });
  await fireEvent.click(screen.getByRole("button", { name: /1 alarm/ }));
  expect(screen.getByRole("dialog").textContent).toContain("Value TWAT");
  expect(screen.getByRole("dialog").textContent).toContain("110");
});

it("another client's control is named, and can be taken", async () => {
  const { asked } = band({ controller: { id: "b", name: "Phone", you: false } as State["controller"] });
  expect(text()).toContain("Phone");
  await fireEvent.click(screen.getByRole("button", { name: /take/i }));
  expect(asked.at(-1)).toMatchObject({ path: "/control/take", body: { force: true } });
});

it("a recording has its time, a marker and an end", async () => {
  const { asked } = band({ recording: { file: "a.pcapng", since: 40, bytes: 2048, failure: null } as unknown as State["recording"] });
  expect(text()).toContain("1:00");
  await fireEvent.click(screen.getByRole("button", { name: "Marker" }));
  expect(asked.at(-1)?.path).toBe("/recording/marker");
});

it("who may only look has no record button", () => {
  band({ rights: "view" });
  expect(screen.queryByRole("button", { name: "Record" })).toBeNull();
});

it("the chip of alarms names the worst one with its value, and how many others there are", () => {
  const alarm = { side: "high", limit: 110, since: 90 };
  const alarms = [
    { ...alarm, name: "UACC", level: "warning", value: 15 },
    { ...alarm, name: "TWAT", level: "danger", value: 120 },
  ] as State["alarms"];
  band({ alarms });
  expect(screen.getByRole("button", { name: /2 alarms: TWAT 120/ }).textContent).toContain("TWAT 120 °C +1");
});
