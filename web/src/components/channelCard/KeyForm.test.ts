import { fireEvent, screen } from "@testing-library/svelte";
import { expect, it } from "vitest";
import { channelOf, eachOnItsOwnPage, page } from "../../../test/pageRig";
import KeyForm from "./KeyForm.svelte";

eachOnItsOwnPage();
const limits = { danger_low: null, warning_low: null, warning_high: 100, danger_high: null, hysteresis: 0 };
const coolant = () => channelOf("TWAT", { limits, gauge: [-40, 130], own: ["limits"] });
const field = (label: RegExp) => screen.getByLabelText<HTMLInputElement>(label);
const save = () => fireEvent.click(screen.getByRole("button", { name: "Save" }));

it("only what was changed is saved, with a comma as well as with a point", async () => {
  const { asked, say, show } = page({ "/channels": { version: "2", parameters: [], derived: [] } });
  say();
  show(KeyForm, { channel: coolant() });
  expect(field(/Warning above/).value).toBe("100");
  await fireEvent.input(field(/Danger above/), { target: { value: "110,5" } });
  await save();
  const [sent] = asked.filter(({ method }) => method === "PUT");
  expect(sent?.path).toContain("/channels/TWAT/keys");
  expect(sent?.body).toMatchObject({ limits: { warning_high: 100, danger_high: 110.5 } });
  expect(sent?.body).not.toHaveProperty("gauge");
});

it("a text that is no number is named, and nothing is sent", async () => {
  const { asked, say, show } = page();
  say();
  show(KeyForm, { channel: coolant() });
  await fireEvent.input(field(/Warning above/), { target: { value: "hot" } });
  await save();
  expect(document.body.textContent).toContain("hot");
  expect(asked.filter(({ method }) => method === "PUT")).toEqual([]);
});

it("a scale with one end is refused", async () => {
  const { asked, say, show } = page();
  say();
  show(KeyForm, { channel: coolant() });
  await fireEvent.input(field(/Gauge from/), { target: { value: "" } });
  await save();
  expect(asked.filter(({ method }) => method === "PUT")).toEqual([]);
});

it("who may only look changes nothing", () => {
  const { say, show } = page();
  say({ rights: "view" });
  show(KeyForm, { channel: coolant() });
  expect(screen.getByRole<HTMLButtonElement>("button", { name: "Save" }).disabled).toBe(true);
  expect(field(/Warning above/).disabled).toBe(true);
});

it("a flag has a choice in the place of limits", () => {
  const { say, show } = page();
  say();
  show(KeyForm, { channel: channelOf("DET", { flag: true }) });
  expect([...field(/Alarm while/).querySelectorAll("option")].map(({ value }) => value)).toEqual(["none", "warning", "danger"]);
  expect(screen.queryByLabelText(/Warning above/)).toBeNull();
});
