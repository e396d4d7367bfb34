import { fireEvent, screen } from "@testing-library/svelte";
import { expect, it } from "vitest";
import { channelOf, eachOnItsOwnPage, page } from "../../../../../test/pageRig";
import Legend from "./Legend.svelte";

eachOnItsOwnPage();
const pane = {
  id: 0,
  traces: [
    { name: "TWAT", colour: 1, hidden: false },
    { name: "FREQ", colour: 2, hidden: true },
  ],
};

function legend() {
  const shown = page();
  shown.say({ plan: { wanted: [{ name: "TWAT" }] } as never });
  shown.stores.catalog.use({ version: "1", parameters: [channelOf("TWAT"), channelOf("FREQ")], derived: [] } as never);
  shown.stores.view.change([pane, { id: 1, traces: [{ name: "THR", colour: 3, hidden: false }] }]);
  shown.show(Legend, { pane });
  return shown.stores;
}
const row = (name: string) => screen.getByTitle(new RegExp(`\\(${name}\\)`));

it("a trace has its name and unit, and whether it is read at all", () => {
  legend();
  expect(row("TWAT").textContent).toContain("°C");
  expect(row("FREQ").textContent).toContain("not sampled");
});

it("a click hides a trace or shows it", async () => {
  const { view } = legend();
  expect(row("TWAT").getAttribute("aria-pressed")).toBe("true");
  await fireEvent.click(row("TWAT"));
  expect(view.panes[0]!.traces.map(({ hidden }) => hidden)).toEqual([true, true]);
});

it("Shift with an arrow moves a trace to the next pane", async () => {
  const { view } = legend();
  await fireEvent.keyDown(row("TWAT"), { code: "ArrowDown", shiftKey: true });
  expect(view.panes.map(({ traces }) => traces.map(({ name }) => name))).toEqual([["FREQ"], ["THR", "TWAT"]]);
});

it("its card opens at the cursor", async () => {
  const { channelCard, cursors } = legend();
  cursors.a = 90;
  await fireEvent.click(screen.getAllByRole("button", { name: /Value TWAT/ }).at(-1)!);
  expect([channelCard.name, channelCard.at]).toEqual(["TWAT", 90]);
});
