import { fireEvent, screen, waitFor } from "@testing-library/svelte";
import { expect, it } from "vitest";
import type { Causes } from "../../lib/api/types";
import { eachOnItsOwnPage, page } from "../../../test/pageRig";
import Screen from "./Screen.svelte";

eachOnItsOwnPage();
const words = (text: string) => ({ en: text, ru: text });
const evidence = {
  ...{ feature: "trim-idle", text: words("mixture correction at idle: 25 %"), value: 25, low: -5, high: 8, recording: null },
  moments: [
    { begin: 100, end: 110 },
    { begin: 200, end: 290 },
  ],
};
const answer: Causes = {
  ...{ verdict: "causes", text: words("What was seen speaks for: Air leak."), seconds: 300, errors: [] },
  causes: [
    {
      ...{ id: "leak", variant: "", likelihood: "almost-certain", likely: words("almost certainly"), text: words("Air leak") },
      ...{ check: words("Spray cleaner"), speaks_for: [evidence], speaks_against: [] },
    },
  ],
  next: [
    { test: "idle", guided: true, text: words("Let it idle."), why: words("It separates.") },
    { test: "drive", guided: false, text: words("Drive."), why: words("It separates.") },
  ],
  not_seen: [words("a cold start")],
  doubts: [words("Not from cars.")],
  complaints: [
    { name: "idles-high", text: words("idles high") },
    { name: "hunts", text: words("hunts") },
  ],
};
const EMPTY = { "/recordings": { recordings: [] }, "/tests/results": { results: [] } };

async function shown(answers: Record<string, unknown> = { "/causes": answer, ...EMPTY }) {
  const rig = page(answers);
  rig.say();
  rig.show(Screen, {});
  await screen.findByText("What was seen speaks for: Air leak.");
  return rig;
}

it("a cause has its likelihood, its evidence, and what to check; the rest is named", async () => {
  await shown();
  const card = screen.getByRole("article", { name: "Air leak" });
  expect(card.textContent).toContain("almost certainly");
  expect(card.textContent).toContain("mixture correction at idle: 25 %");
  expect(card.textContent).toContain("2 moments");
  expect(card.textContent).toContain("Spray cleaner");
  expect(document.body.textContent).toContain("a cold start");
  expect(document.body.textContent).toContain("Not from cars.");
});

it("a complaint is one touch, asks again while the answer stays, and is taken back by another", async () => {
  const { asked } = await shown();
  await fireEvent.click(screen.getByRole("button", { name: "idles high" }));
  expect(screen.getByRole("article", { name: "Air leak" })).toBeTruthy();
  await waitFor(() => expect(asked.some(({ path }) => path === "/causes?complaint=idles-high")).toBe(true));
  const chip = screen.getByRole("button", { name: "idles high" });
  expect(chip.getAttribute("aria-pressed")).toBe("true");
  await fireEvent.click(chip);
  expect(chip.getAttribute("aria-pressed")).toBe("false");
});

it("an evidence shows its longest moment between the chart's cursors", async () => {
  const { stores } = await shown();
  await fireEvent.click(screen.getByRole("button", { name: /Show in the chart: mixture/ }));
  await waitFor(() => expect(stores.route.screen).toBe("chart"));
  expect([stores.cursors.a, stores.cursors.b]).toEqual([200, 290]);
});

it("the next measurement starts as a guided test; a drive is only described", async () => {
  const { asked, stores } = await shown({ "/causes": answer, "/tests/idle/start": { run: null }, ...EMPTY });
  expect(screen.getAllByRole("button", { name: "Start the test" })).toHaveLength(1);
  await fireEvent.click(screen.getByRole("button", { name: "Start the test" }));
  await waitFor(() => expect(asked.some(({ method, path }) => method === "POST" && path === "/tests/idle/start")).toBe(true));
  await waitFor(() => expect(stores.route.screen).toBe("tests"));
});

it("of a recording in the address its causes are asked for", async () => {
  location.hash = "#/causes/drive.pcapng";
  const { asked } = await shown({ "/recordings/drive.pcapng/causes": answer, ...EMPTY });
  expect(asked.some(({ path }) => path === "/recordings/drive.pcapng/causes")).toBe(true);
  expect(document.body.textContent).toContain("recording drive");
});

it("without a car there is a way to the connection", () => {
  const { say, show } = page();
  say({ line: "off" });
  show(Screen, {});
  expect(document.body.textContent).toContain("Causes are looked for in the values of a car");
});
