import { fireEvent, screen, within } from "@testing-library/svelte";
import { flushSync } from "svelte";
import { expect, it } from "vitest";
import { channelOf, eachOnItsOwnPage, page } from "../../../../test/pageRig";
import type { Instruments } from "../../../lib/api/types";
import { channelsOf, definitionOf, draftOf, namesIn, notNumber } from "./draft";
import Ports from "../Ports.svelte";
import Screen from "../Screen.svelte";
import InstrumentsCard from "./InstrumentsCard.svelte";
import InstrumentSheets from "./InstrumentSheets.svelte";

eachOnItsOwnPage();
const words = (text: string) => ({ en: text, ru: text });
const definition = (name: string, at: "port" | "gpsd" | "position", own = false) => ({
  ...{ name, text: words(`The ${name}`), decoder: "line", baud: 9600, stale: 1, patterns: [], decimal: "." },
  ...{ channels: [], confidence: "reported" as const, own, at },
});
const LAMBDA = channelOf("LAMBDA", { instrument: true, decimals: 3 });
const NONE = {
  ...{ instruments: [], channels: [], known: [LAMBDA], problems: [], network: true },
  definitions: [definition("aem", "port"), definition("gpsd", "gpsd"), definition("phone", "position")],
} as Instruments;
const METER = {
  ...{ name: "aem", state: "lost" as const, text: words("Not there"), damaged: 3, definition: "aem", label: "" },
  ...{ port: "COM4", title: words("The meter"), channels: ["LAMBDA"] },
};
const ONE = { ...NONE, instruments: [METER], channels: [LAMBDA] };

async function card(list: Instruments, allowed = true) {
  const ports = [
    { url: "COM3", chip: "FT232R", description: "", likely: true, quirks: [] },
    { url: "COM4", chip: "CH340", description: "", likely: true, quirks: [] },
  ];
  const shown = page({ "/instruments": list, "/ports": { ports } });
  shown.say({ line: "sampling", port: "COM3", instruments: [] });
  await shown.stores.instruments.list.reload();
  await shown.stores.connection.ports.reload();
  shown.show(InstrumentsCard, { allowed });
  shown.show(InstrumentSheets, {});
  flushSync();
  return shown;
}
const sent = ({ asked }: Awaited<ReturnType<typeof card>>) =>
  asked.filter(({ method }) => method !== "GET").map(({ method, path, body }) => [method, path, body]);
const press = (name: string) => fireEvent.click(screen.getByRole("button", { name }));
const pick = (label: string, value: string) => fireEvent.change(screen.getByLabelText(label), { target: { value } });

it("an instrument is added at a port that neither the unit nor another one has", async () => {
  const shown = await card(NONE);
  await press("Add an instrument…");
  await pick("Instrument", "aem");
  const offered = [...screen.getByLabelText("Port").querySelectorAll("option")].map(({ value }) => value);
  expect(offered).toEqual(["", "COM4", "other"]);
  expect(screen.getByRole<HTMLButtonElement>("button", { name: "Add" }).disabled).toBe(true);
  await pick("Port", "COM4");
  await press("Add");
  expect(sent(shown)).toEqual([["POST", "/instruments", { definition: "aem", port: "COM4", label: "" }]]);
});

it("a virtual car has instruments in it, but not a definition of one's own", async () => {
  const shown = await card({ ...NONE, definitions: [...NONE.definitions, definition("boost", "port", true)] });
  shown.say({ port: "sim:", demo: true });
  await press("Add an instrument…");
  const offered = () => [...screen.getByLabelText("Port").querySelectorAll("option")].map(({ value }) => value);
  await pick("Instrument", "aem");
  expect(offered()).toContain("sim:");
  await pick("Instrument", "boost");
  expect(offered()).not.toContain("sim:");
});

it("gpsd has an address, and on a page that can't reach it the reason stands there", async () => {
  await card({ ...NONE, network: false });
  await press("Add an instrument…");
  await pick("Instrument", "gpsd");
  expect(document.body.textContent).toContain("A page can't reach gpsd");
  expect(screen.getByRole<HTMLButtonElement>("button", { name: "Add" }).disabled).toBe(true);
});

it("the state, the damage and the port of each are shown, the state by the live messages", async () => {
  const shown = await card(ONE);
  const line = () => document.querySelector("[data-instrument=aem]")!;
  expect(line().textContent).toContain("Not there · 3 messages gave no value");
  shown.say({ instruments: [{ name: "aem", state: "values", text: words("Values come."), damaged: 0 }] });
  flushSync();
  expect(line().getAttribute("data-state")).toBe("values");
  expect(line().textContent).toContain("Values come.");
});

it("one is removed after a question", async () => {
  const shown = await card(ONE);
  await press("Remove");
  expect(sent(shown)).toEqual([]);
  await fireEvent.click(within(screen.getByRole("dialog")).getByRole("button", { name: "Remove" }));
  expect(sent(shown)).toEqual([["DELETE", "/instruments/aem", undefined]]);
});

it("without control nothing can be changed", async () => {
  await card(ONE, false);
  for (const name of ["Add an instrument…", "Remove"]) expect(screen.getByRole<HTMLButtonElement>("button", { name }).disabled).toBe(true);
});

it("their channels are known on every screen, and are not asked of the unit", async () => {
  const shown = await card(ONE);
  const { catalog, instruments, subscriptions } = shown.stores;
  const end = $effect.root(() => instruments.follow());
  flushSync();
  expect(catalog.channels.map(({ name }) => name)).toContain("LAMBDA");
  expect(catalog.ofUnit).toEqual([]);
  subscriptions.set("preset", ["LAMBDA"], false);
  expect(subscriptions.names).toEqual([]);
  end();
});

it("an instrument's port is not offered for the unit", async () => {
  const shown = await card(ONE);
  shown.say({ line: "off", port: null });
  shown.show(Ports, { allowed: true });
  flushSync();
  expect(screen.queryByRole("button", { name: "Connect to COM4" })).toBeNull();
  expect(screen.getByRole("button", { name: "Connect to COM3" })).toBeDefined();
});

it("a definition's values are those of its patterns, and the catalog's are not described again", () => {
  expect(namesIn("P={BOOST_BAR} bar, {} C*\n{LAMBDA} \\{NO}\n{BOOST_BAR}")).toEqual(["BOOST_BAR", "LAMBDA"]);
  const draft = { ...draftOf(null, ({ en }) => en), name: "boost", patterns: "P={BOOST_BAR}\n\n{LAMBDA}", stale: "0,5" };
  const known = (name: string) => name === "LAMBDA";
  const [boost] = channelsOf(draft, known);
  draft.channels = [{ ...boost!, unit: "bar", low: "−1", high: "4" }];
  expect(definitionOf(draft, known, null, ({ en }) => en)).toEqual({
    ...{ text: words("boost"), baud: 9600, patterns: ["P={BOOST_BAR}", "{LAMBDA}"], decimal: ".", stale: 0.5 },
    channels: [{ name: "BOOST_BAR", text: words("BOOST_BAR"), unit: "bar", range: [-1, 4] }],
  });
  expect(notNumber(draft)).toBeUndefined();
  expect(notNumber({ ...draft, baud: "fast" })).toBe("fast");
});

it("what is not changed of a definition keeps its other language", () => {
  const text = { en: "Boost", ru: "Наддув" };
  const before = {
    ...definition("boost", "port", true),
    text,
    patterns: ["{BOOST}"],
    channels: [channelOf("BOOST", { text, unit_key: "bar" })],
  };
  const said = (texts: { ru: string }) => texts.ru;
  const draft = draftOf(before, said);
  expect(definitionOf(draft, () => false, before, said)).toMatchObject({ text, channels: [{ text, unit: "bar" }] });
  const changed = definitionOf({ ...draft, text: "Турбо" }, () => false, before, said);
  expect(changed).toMatchObject({ text: { en: "Турбо", ru: "Турбо" }, channels: [{ text }] });
});

it("a definition that is being written stays while the card is cut off from the program, and goes with the screen", async () => {
  const shown = page({ "/instruments": NONE, "/ports": { ports: [] }, "/about": { lan_links: [], links: [] } });
  shown.say({ line: "sampling", port: "COM3", instruments: [] });
  await shown.stores.instruments.list.reload();
  const whole = shown.show(Screen, {});
  flushSync();
  await press("Add an instrument…");
  await pick("Instrument", "own");
  await fireEvent.input(screen.getByLabelText("Name"), { target: { value: "boost" } });
  shown.stores.live.link = "lost";
  flushSync();
  expect(screen.queryByRole("button", { name: "Add an instrument…" })).toBeNull();
  shown.stores.live.link = "open";
  flushSync();
  expect(screen.getByLabelText<HTMLInputElement>("Name").value).toBe("boost");
  await whole.unmount();
  expect(shown.stores.instruments.sheet).toBeNull();
});

it("a pattern that claims the name of the unit's channel is refused where it is typed, with what to do", async () => {
  const shown = await card(NONE);
  shown.stores.catalog.use({ version: "1", parameters: [channelOf("FREQ")], derived: [], faults: [] } as never);
  await press("Add an instrument…");
  await pick("Instrument", "own");
  const type = (label: RegExp | string, value: string) => fireEvent.input(screen.getByLabelText(label), { target: { value } });
  await type("Name", "rpm");
  await type(/^What a line looks/, "R={FREQ}");
  expect(document.body.textContent).toContain("FREQ is a channel of the unit itself: write another name in the pattern, as {MY_FREQ}.");
  expect(screen.getByRole<HTMLButtonElement>("button", { name: "Save" }).disabled).toBe(true);
  await type(/^What a line looks/, "R={MY_FREQ}");
  expect(screen.getByRole<HTMLButtonElement>("button", { name: "Save" }).disabled).toBe(false);
});
