import { fireEvent, screen } from "@testing-library/svelte";
import { expect, it } from "vitest";
import type { Fault } from "../../lib/api/types";
import { channelOf, eachOnItsOwnPage, page } from "../../../test/pageRig";
import FaultCard from "./FaultCard.svelte";
import Journal from "./Journal.svelte";

eachOnItsOwnPage();
const words = (text: string) => ({ en: text, ru: text });
const fault = {
  ...{ code: 17, text: words("Air temperature signal low"), certain: true, informational: false, confidence: "confirmed" },
  ...{ check: words("Connector and wiring"), related: ["TAIR"], sensor: ["TAIR"], first_seen: 90 },
} as unknown as Fault;

it("a fault has its number, its text, what to check, and the substitute value", () => {
  const { say, show, stores } = page();
  say();
  stores.catalog.use({ version: "1", parameters: [channelOf("TAIR")], derived: [] } as never);
  show(FaultCard, { fault, frame: undefined });
  const card = screen.getByRole("article", { name: "17: Air temperature signal low" });
  expect(card.textContent).toContain("Connector and wiring");
  expect(card.textContent).toContain("substitute value: Value TAIR");
});

it("a related value that is not read can be added to the plan", async () => {
  const { asked, say, show } = page();
  say();
  show(FaultCard, { fault, frame: undefined });
  await fireEvent.click(screen.getByRole("button", { name: "Add to live values" }));
  expect(asked.some(({ method, path }) => method === "PUT" && path.startsWith("/plan"))).toBe(true);
});

it("who may only look is not offered that", () => {
  const { say, show } = page();
  say({ rights: "view" });
  show(FaultCard, { fault, frame: undefined });
  expect(screen.queryByRole("button", { name: "Add to live values" })).toBeNull();
});

it("the journal has an erase with its codes, and the outcome of what failed", async () => {
  const entry = { time: 100, port: "COM3", command: "05", before: "11 29", after: null };
  const entries = [
    { ...entry, change: words("write THR"), state: "failed", before: "01", after: "02", outcome: "the unit refused" },
    { ...entry, change: words("erase 2 stored fault(s)"), state: "done", outcome: [] },
  ];
  const { show, stores } = page({ "/journal": { entries } });
  await stores.faults.journal.reload();
  show(Journal, {});
  const items = [...document.querySelectorAll("li")].map((item) => item.textContent.replace(/\s+/g, " "));
  expect(items[0]).toContain("write THR");
  expect(items[0]).toContain("the unit refused");
  expect(items[1]).toContain("17, 41");
});
