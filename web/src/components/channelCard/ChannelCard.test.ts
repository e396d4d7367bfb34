import { fireEvent, screen } from "@testing-library/svelte";
import { expect, it, vi } from "vitest";
import { channelOf, eachOnItsOwnPage, page } from "../../../test/pageRig";
import ChannelCard from "./ChannelCard.svelte";

eachOnItsOwnPage();
const words = (text: string) => ({ en: text, ru: text });
const coolant = channelOf("TWAT", {
  ...{
    formula: "x - 40",
    inputs: null,
    errata: [],
    otherwise: [{ name: "family", formula: "(b + 128)/256", unit: words("") }],
    source: "§4.2",
    confidence: "confirmed",
    evidence: {
      source: words("the letter"),
      siblings: words("another formula"),
      sightings: [{ unit: "0A, 2026-12-05", agreement: "agrees", text: words("85 at warm idle") }],
    },
    range: null,
    constants: {},
    range_kind: "",
    reference_confidence: "confirmed",
    accumulates: false,
    instrument: false,
    unit_key: "",
    code: 18,
    size: 1,
    writable: false,
  },
  ...{ meaning: { low: null, high: words("The thermostat stays shut"), confidence: "confirmed" }, reference: [80, 95] },
  limits: { danger_low: null, warning_low: null, warning_high: 80, danger_high: null, hysteresis: 0 },
});

function card({ at = null }: { at?: number | null } = {}) {
  const shown = page({
    "/references": { virtual: [], recordings: [] },
    "/channels/TWAT/value": { value: 87, raw: "7F", time: 99, otherwise: { family: 1.004 } },
  });
  shown.say();
  shown.stores.catalog.use({ version: "1", parameters: [coolant], derived: [], faults: [] } as never);
  const onclose = vi.fn();
  shown.show(ChannelCard, { name: "TWAT", at, onclose });
  return { ...shown, onclose };
}
const text = () => screen.getByRole("dialog").textContent.replace(/\s+/g, " ");

it("what a channel means and where it comes from is there", () => {
  card();
  expect(text()).toContain("Value TWAT");
  expect(text()).toContain("The thermostat stays shut");
  expect(text()).toContain("x - 40");
  expect(text()).toContain("Otherwise: family (b + 128)/256");
  expect(text()).toContain("What the source says the letter");
  expect(text()).toContain("Sibling units, other texts another formula");
  expect(text()).toContain("Seen on a unit 0A, 2026-12-05: 85 at warm idle (agrees)");
});

it("at a moment it has that moment's value, its bytes, and the limit that it is beyond", async () => {
  card({ at: 99 });
  await vi.waitFor(() => expect(text()).toContain("Above the limit 80"));
  expect(text()).toContain("7F");
  expect(text()).toContain("(b + 128)/256 that is 1");
});

it("what is not read can be read", async () => {
  const { asked } = card();
  expect(text()).toContain("It is not being read now");
  await fireEvent.click(screen.getByRole("button", { name: "Read it" }));
  expect(asked.some(({ method, path }) => method === "PUT" && path.startsWith("/plan"))).toBe(true);
});

it("it closes", async () => {
  const { onclose } = card();
  await fireEvent.click(screen.getAllByRole("button", { name: "Close" })[0]!);
  expect(onclose).toHaveBeenCalled();
});
