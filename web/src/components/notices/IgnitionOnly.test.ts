import { fireEvent, screen } from "@testing-library/svelte";
import { flushSync } from "svelte";
import { beforeEach, expect, it } from "vitest";
import { channelOf, eachOnItsOwnPage, page } from "../../../test/pageRig";
import Live from "../../screens/live/Screen.svelte";
import Chart from "../../screens/chart/Screen.svelte";
import type { Preset } from "../../lib/api/types";

eachOnItsOwnPage();
beforeEach(() => localStorage.clear());

const NAMES = ["FREQ", "INJ", "JAIR", "TWAT"];
const words = (text: string) => ({ en: text, ru: text });
const tile = (kind: Preset["tiles"][number]["kind"], ...names: string[]) => ({ kind, names, span: 1, scale: null });
const PRESET: Preset = {
  id: "idle",
  name: words("Idle"),
  shipped: true,
  tiles: [tile("number", "FREQ"), tile("number", "INJ"), tile("number", "JAIR"), tile("table")],
};

function shown(screenOf: typeof Live | typeof Chart) {
  const it = page({ "/presets": { presets: [] } });
  it.say({ absent: ["INJ", "JAIR"] });
  const channels = NAMES.map((name) => channelOf(name, { gauge: [0, 100], span_least: 1, reference: null }));
  it.stores.catalog.use({ version: "1", parameters: channels, derived: [], faults: [], presets: [PRESET] } as never);
  it.show(screenOf, {});
  flushSync();
  return it;
}
const said = () => document.querySelectorAll("[data-ignition-only]").length;
const titles = () => [...document.querySelectorAll("td, th, .name")].map((each) => each.textContent.trim());

it("Live leaves out what an ignition-only unit does not have, and says so once", () => {
  const { stores } = shown(Live);
  expect(said()).toBe(1);
  expect(stores.presets.onScreen?.tiles.map(({ names }) => names)).toEqual([["FREQ"], []]);
  expect(stores.presets.names).toEqual(["FREQ", "TWAT"]);
  expect(titles().some((text) => text.includes("INJ"))).toBe(false);
});

it("they can be shown all the same, and left out again", async () => {
  const { stores } = shown(Live);
  await fireEvent.click(screen.getByRole("button", { name: "Show them anyway" }));
  expect(stores.presets.names).toEqual(NAMES);
  expect(said()).toBe(1);
  await fireEvent.click(screen.getByRole("button", { name: "Leave them out" }));
  expect(stores.presets.names).toEqual(["FREQ", "TWAT"]);
});

it("a value that is shown all the same is still known as one that the unit does not have", () => {
  const { absent } = shown(Live).stores;
  absent.wanted = true;
  expect([absent.hides("INJ"), absent.has("INJ"), absent.has("FREQ")]).toEqual([false, true, false]);
});

it("the preset that is edited and stored is whole", () => {
  const { stores } = shown(Live);
  stores.presets.edit();
  expect(stores.presets.onScreen?.tiles).toHaveLength(4);
});

it("another car has all its channels again", () => {
  const it = shown(Live);
  it.say({ absent: [] });
  flushSync();
  expect([said(), it.stores.presets.names]).toEqual([0, NAMES]);
});

it("the chart leaves their traces out, and keeps them for another car", () => {
  const it = shown(Chart);
  expect(said()).toBe(1);
  expect(it.stores.view.names).not.toContain("INJ");
  it.stores.view.remove("UOZ");
  it.say({ absent: [] });
  flushSync();
  expect(it.stores.view.names).toEqual(expect.arrayContaining(["FREQ", "THR", "INJ", "JAIR", "TWAT", "UACC"]));
  expect(it.stores.view.names).not.toContain("UOZ");
});

it("an opened recording of such a unit is treated alike", () => {
  const it = page();
  it.say();
  it.stores.player.detail = { absent: ["INJ"], events: [] } as never;
  expect(it.stores.absent.hides("INJ")).toBe(false);
  it.stores.display.play(it.stores.player);
  expect([it.stores.absent.any, it.stores.absent.hides("INJ")]).toEqual([true, true]);
});
