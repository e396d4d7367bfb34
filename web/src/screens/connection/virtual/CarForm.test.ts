import { fireEvent, screen } from "@testing-library/svelte";
import { flushSync } from "svelte";
import { expect, it } from "vitest";
import type { VirtualCars } from "../../../lib/api/types";
import { eachOnItsOwnPage, page } from "../../../../test/pageRig";
import { shortPort } from "../Ports.svelte";
import BlindAnswer from "./BlindAnswer.svelte";
import { amountAt, amountText, blindCar, placeOf } from "./car";
import CarForm from "./CarForm.svelte";

eachOnItsOwnPage();
const both = (text: string) => ({ en: text, ru: text });
const LEAK = {
  key: "leak",
  text: both("Leak"),
  phrase: both("{}"),
  unit: both("kg/h"),
  percent: false,
  sound: 0,
  least: 2,
  noticeable: 6,
  most: 20,
};
const WEAK = {
  key: "starter",
  text: both("Weak starter"),
  phrase: both("{} left"),
  unit: both("%"),
  percent: true,
  sound: 1,
  least: 0.8,
  noticeable: 0.6,
  most: 0.4,
};
const CARS: VirtualCars = {
  scenarios: [
    { name: "warm-idle", text: both("Warm idle") },
    { name: "mixed", text: both("Mixed") },
  ],
  defects: [LEAK, WEAK],
};

async function form() {
  const shown = page({ "/virtual-cars": CARS });
  shown.say({ line: "off", port: null });
  shown.show(CarForm, { disabled: false });
  const details = screen.getByText("Choose a car and its defect").closest("details")!;
  details.open = true;
  await fireEvent(details, new Event("toggle"));
  await screen.findByLabelText("Drive");
  return shown;
}
const started = async ({ asked }: Awaited<ReturnType<typeof form>>) => {
  await fireEvent.click(screen.getByRole("button", { name: "Start this car" }));
  flushSync();
  return asked.filter(({ path }) => path === "/connect").map(({ body }) => (body as { port: string }).port);
};

it("a defect starts with its noticeable amount, which the slider changes", async () => {
  const shown = await form();
  expect(screen.getByText("6 kg/h")).toBeTruthy();
  await fireEvent.input(screen.getByRole("slider"), { target: { value: "100" } });
  expect(await started(shown)).toEqual(["sim:?scenario=mixed&car=leak:20"]);
});

it("another defect has amounts of its own, and another drive is another scenario", async () => {
  const shown = await form();
  await fireEvent.input(screen.getByRole("slider"), { target: { value: "100" } });
  await fireEvent.change(screen.getByLabelText("Defect"), { target: { value: "1" } });
  expect(screen.getByText("60 % left")).toBeTruthy();
  await fireEvent.change(screen.getByLabelText("Drive"), { target: { value: "warm-idle" } });
  expect(await started(shown)).toEqual(["sim:?scenario=warm-idle&car=starter:0.6"]);
});

it("the drive stands below its list, which may cut it", async () => {
  await form();
  await fireEvent.change(screen.getByLabelText("Drive"), { target: { value: "warm-idle" } });
  expect(screen.getByText("Warm idle", { selector: "p" })).toBeTruthy();
});

it("a blind car is started by its number, and no other text", async () => {
  const shown = await form();
  await fireEvent.click(screen.getByRole("button", { name: "Find out what is wrong" }));
  await fireEvent.input(screen.getByLabelText("Number"), { target: { value: "x" } });
  expect(screen.getByRole<HTMLButtonElement>("button", { name: "Start this car" }).disabled).toBe(true);
  await fireEvent.input(screen.getByLabelText("Number"), { target: { value: "4711" } });
  expect(await started(shown)).toEqual(["sim:?scenario=mixed&car=blind:4711"]);
});

it("a sound car is a healthy one", async () => {
  const shown = await form();
  await fireEvent.click(screen.getByRole("button", { name: "Sound" }));
  expect(await started(shown)).toEqual(["sim:?scenario=mixed&car=healthy"]);
});

it("a car with a carburettor has a unit that controls the ignition alone", async () => {
  const shown = await form();
  await fireEvent.click(screen.getByRole("button", { name: "Carburettor" }));
  expect(await started(shown)).toEqual(["sim:?scenario=mixed&model=5.4&ignition_only=yes"]);
});

it("the answer is asked for by the button only, and may be that nothing is wrong", async () => {
  const shown = page({ "/virtual-cars/answer": { car: "blind:7", defects: [] } });
  shown.show(BlindAnswer, { car: "blind:7" });
  expect(shown.asked.filter(({ path }) => path.startsWith("/virtual-cars"))).toEqual([]);
  await fireEvent.click(screen.getByRole("button", { name: "Show the answer" }));
  expect(await screen.findByText("Nothing: this car is sound.")).toBeTruthy();
});

it("amounts and addresses are read both ways", () => {
  expect([placeOf(WEAK, 0.6), amountAt(WEAK, 50), amountText(WEAK, 0.6)]).toEqual([50, 0.6, "60\u00a0%"]);
  expect(["sim:?car=blind:7", "sim:?scenario=mixed&car=blind:7&seed=1", "sim:?car=leak:7", "COM3", null].map(blindCar)).toEqual([
    "blind:7",
    "blind:7",
    null,
    null,
    null,
  ]);
  expect(["sim:", "sim:?seed=1", "sim:?scenario=city&seed=1", "sim:?car=leak:8&scenario=city", "COM3"].map(shortPort)).toEqual([
    "sim:",
    "sim:?seed=1",
    "sim: city",
    "sim: city leak:8",
    "COM3",
  ]);
});
