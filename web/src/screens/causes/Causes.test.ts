import { fireEvent, screen, waitFor } from "@testing-library/svelte";
import { expect, it, vi } from "vitest";
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
    { test: "idle", guided: true, text: words("Let it idle."), why: words("It separates."), outcomes: [] },
    { test: "drive", guided: false, text: words("Drive."), why: words("It separates."), outcomes: [] },
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

it("a test by hand is described with what each outcome means, and starts nothing", async () => {
  const outcomes = [
    { text: words("13.6 V or more"), cause: "alternator", means: words("Weak alternator") },
    { text: words("less than 13.6 V"), cause: "regulator", means: words("Regulator set low") },
  ];
  const by_hand = { test: "by-hand", guided: false, text: words("A voltmeter."), why: words("The unit's values don't."), outcomes };
  await shown({ "/causes": { ...answer, next: [by_hand] }, ...EMPTY });
  const card = document.querySelector("[data-next=by-hand]")!;
  expect(card.textContent).toContain("A voltmeter.");
  expect([...card.querySelectorAll("li")].map((it) => it.textContent)).toEqual([
    "13.6 V or more: Weak alternator",
    "less than 13.6 V: Regulator set low",
  ]);
  expect(card.querySelector("button")).toBeNull();
});

it("of a recording in the address its causes are asked for", async () => {
  location.hash = "#/causes/drive.pcapng";
  const { asked } = await shown({ "/recordings/drive.pcapng/causes": answer, ...EMPTY });
  expect(asked.some(({ path }) => path === "/recordings/drive.pcapng/causes")).toBe(true);
  expect(document.body.textContent).toContain("recording drive");
});

const recording = (id: string, date: number, plate: string) => ({
  ...{ id, date, bytes: 0, length: 60, model: words("Mikas 7.1"), passport: null, samples: 60, samples_exact: true, rate: 1 },
  ...{ gaps: 0, faults: [], markers: 0, note: "", car: { car: "", plate, mileage: null, workshop: "" } },
  ...{ open: false, reference: false, virtual: false, clock: [], problem: null },
});
const LIST = { recordings: [recording("a.pcapng", 3, "A1"), recording("b.pcapng", 2, "A1"), recording("other.pcapng", 1, "B2")] };

it("other recordings of the car are ticked, and another car's are not offered", async () => {
  location.hash = "#/causes/a.pcapng";
  const { asked, stores } = await shown({ "/recordings/a.pcapng/causes": answer, ...EMPTY, "/recordings": LIST });
  const boxes = await screen.findAllByRole("checkbox", { hidden: true });
  expect(boxes.map((box) => box.parentElement?.textContent)).toEqual([expect.stringContaining("b")]);
  await fireEvent.click(boxes[0]!);
  await waitFor(() => expect(asked.some(({ path }) => path === "/recordings/a.pcapng/causes?with=b.pcapng")).toBe(true));
  expect(stores.route.rest).toEqual(["a.pcapng", "b.pcapng"]);
  expect(document.body.textContent).toContain("recording a and 1 more");
  await fireEvent.click((await screen.findAllByRole("checkbox", { hidden: true }))[0]!);
  await waitFor(() => expect(stores.route.rest).toEqual(["a.pcapng"]));
});

it("an evidence of several recordings names its own, and opens that one", async () => {
  location.hash = "#/causes/a.pcapng/b.pcapng";
  const mine = { ...evidence, recording: "b.pcapng" };
  const of = { ...answer, causes: [{ ...answer.causes[0]!, speaks_for: [mine] }] };
  const { stores } = await shown({ "/recordings/a.pcapng/causes": of, ...EMPTY, "/recordings": LIST });
  const opened = vi.spyOn(stores.player, "open").mockResolvedValue(undefined);
  const button = screen.getByRole("button", { name: /Show in the chart: mixture/ });
  expect(button.textContent).toContain("b · ");
  await fireEvent.click(button);
  await waitFor(() => expect(opened).toHaveBeenCalledWith("b.pcapng"));
});

it("with no car connected the newest recording is looked at", async () => {
  const { asked } = await (async () => {
    const rig = page({ "/recordings/a.pcapng/causes": answer, ...EMPTY, "/recordings": LIST });
    rig.say({ line: "off" });
    rig.show(Screen, {});
    await screen.findByText("What was seen speaks for: Air leak.");
    return rig;
  })();
  expect(asked.some(({ path }) => path === "/recordings/a.pcapng/causes")).toBe(true);
});

it("recordings of different cars are refused in words", async () => {
  location.hash = "#/causes/a.pcapng/other.pcapng";
  const text = "it is a recording of B2, and a.pcapng is one of A1";
  const refused = { code: "SeveralCars", en: text, ru: text, sent: null, received: null };
  const refusal = () => new Response(JSON.stringify({ error: refused }), { status: 400 });
  const { say, show } = page({ "/recordings/a.pcapng/causes": refusal, ...EMPTY, "/recordings": LIST });
  say();
  show(Screen, {});
  await screen.findByText(/it is a recording of B2/);
  expect(screen.getAllByRole("checkbox", { hidden: true })).toHaveLength(2);
});

it("without a car there is a way to the connection", () => {
  const { say, show } = page();
  say({ line: "off" });
  show(Screen, {});
  expect(document.body.textContent).toContain("Causes are looked for in the values of a car");
});
