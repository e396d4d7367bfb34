import { fireEvent, screen, waitFor } from "@testing-library/svelte";
import { expect, it } from "vitest";
import type { Trip, TripSums } from "../../../lib/api/types";
import { eachOnItsOwnPage, page, refused } from "../../../../test/pageRig";
import Screen from "./Screen.svelte";

eachOnItsOwnPage();
const words = (text: string) => ({ en: text, ru: text });
const total: TripSums = {
  ...{ begin: 1000, end: 2000, seconds: 1000, gap_seconds: 4, litres: 2.61, litres_from: "JQT", fuel_seconds: 996 },
  ...{ kilometres: 18.9, speed_seconds: 1000, idle_seconds: 588, idle_known: 1000, litres_per_100_km: 13.8 },
  ...{ mean_speed: 36, highest_speed: 91, mean_rpm: 1742, highest_rpm: 3960 },
};
const none: Trip = { trips: [], count: 0, total: null, lacks: [], marks: [], way: null, mixture: null, channels: ["FREQ", "GPS_SPEED"] };
const whole: Trip = {
  ...none,
  ...{ trips: [total], count: 1, total, marks: [{ time: 1500, label: "filled up" }] },
  way: {
    ...{ colour: "GPS_SPEED", ends: [20, 40, 60, 90] },
    lines: [
      { level: 0, east: [0, 10], north: [0, 20] },
      { level: null, east: [10, 900], north: [20, 700] },
    ],
  },
  mixture: {
    ...{ load: "THR", unsteady: 5, lean: 2 },
    cells: [{ rpm: [1600, 2200], load: [20, 35], count: 80, aimed: 1, measured: 1.08, difference: 8, verdict: "leaner" }],
  },
};

async function shown(of: string, answer: unknown, state = {}) {
  location.hash = `#/recordings/trip/${of}`;
  const rig = page({
    "/recordings/drive.pcapng/trip": answer,
    "/trip": answer,
    "/recording/marker": { time: 1900 },
    "/recordings": { recordings: [] },
  });
  rig.say(state);
  rig.show(Screen, {});
  await waitFor(() => expect(rig.asked.some(({ path }) => path.includes("/trip"))).toBe(true));
  return rig;
}
const sum = (key: string) => document.querySelector(`[data-sum=${key}] dd`)?.textContent;

it("a recording has its sums, its way with what the colours mean, and the measured mixture", async () => {
  await shown("drive.pcapng", whole);
  await screen.findByText("13.8 l");
  expect([sum("litres"), sum("kilometres"), sum("ran"), sum("stood")]).toEqual(["2.61 l", "18.9 km", "16:40", "09:48"]);
  expect([sum("speed"), sum("rpm"), sum("gaps")]).toEqual(["36 (91) km/\u2060h", "1742 (3960) rpm", "00:04"]);
  expect(document.querySelectorAll("[data-way] path")).toHaveLength(2);
  expect(screen.getByRole("list", { name: "Colour" }).textContent).toMatch(/below 20.*unknown/);
  expect(screen.getByRole("list", { name: "Colour" }).textContent).not.toContain("90");
  expect(document.body.textContent).toContain("leaner than aimed");
  expect(document.body.textContent).toContain("5 values while speed or load changed");
});

it("a mark is where it counts from, and the files follow it", async () => {
  const { asked } = await shown("drive.pcapng", whole);
  await fireEvent.change(await screen.findByLabelText("Count from"), { target: { value: "1500" } });
  await waitFor(() => expect(asked.some(({ path }) => path.includes("/trip?since=1500"))).toBe(true));
  await fireEvent.click(screen.getByRole("button", { name: "Save for maps: .gpx" }));
  await waitFor(() => expect(asked.some(({ path }) => path === "/recordings/drive.pcapng/trip/gpx?since=1500&lang=en")).toBe(true));
});

it("another channel colours the way", async () => {
  const { asked } = await shown("drive.pcapng", whole);
  await fireEvent.change(await screen.findByLabelText("Colour", { selector: "select" }), { target: { value: "FREQ" } });
  await waitFor(() => expect(asked.some(({ path }) => path.endsWith("colour=FREQ"))).toBe(true));
});

it("what is missing is said, with dashes in the place of figures", async () => {
  const poor = { ...total, litres: null, kilometres: null, litres_per_100_km: null, mean_speed: null, highest_speed: null };
  await shown("drive.pcapng", { ...none, trips: [poor], count: 1, total: poor, lacks: [words("No GPS was there.")] });
  await screen.findByText("No GPS was there.");
  expect([sum("litres"), sum("kilometres"), sum("per_100"), sum("speed")]).toEqual(["–", "–", "–", "–"]);
  expect(screen.queryByRole("button", { name: /Save for maps/ })).toBeNull();
  expect(document.body.textContent).toContain("With a λ meter beside the unit");
});

it("an engine that stood is no trip, and several drives have a row each", async () => {
  await shown("drive.pcapng", none);
  await screen.findByText("The engine did not run.");
});

it("several drives have a row each, and the latest of very many are named so", async () => {
  await shown("drive.pcapng", { ...whole, trips: [total, { ...total, begin: 5000 }], count: 900 });
  await screen.findByText("The latest 2 are shown.");
  expect(screen.getByRole("group", { name: "Each drive" }).querySelectorAll("tbody tr")).toHaveLength(2);
});

it("the connected car counts from the present moment after one touch", async () => {
  const { asked } = await shown("live", whole);
  await fireEvent.click(await screen.findByRole("button", { name: "Count from now" }));
  await waitFor(() => expect(asked.some(({ method, path }) => method === "POST" && path === "/recording/marker")).toBe(true));
  await waitFor(() => expect(asked.some(({ path }) => path.startsWith("/trip?since=1900"))).toBe(true));
});

it("an error is said in its place, and without a car there is a way to the connection", async () => {
  await shown("drive.pcapng", () => refused(404, "NotFound"));
  await screen.findByText(/Advice on NotFound/);
});

it("without a car there is a way to the connection", () => {
  location.hash = "#/recordings/trip/live";
  const { say, show } = page();
  say({ line: "off" });
  show(Screen, {});
  expect(document.body.textContent).toContain("A trip is counted from the values of a car");
});

const point = (rpm: number, power: number) => ({ rpm, speed: rpm / 40, power, doubt: 4, torque: 180, torque_doubt: 8 });

it("a pull is computed with the car's figures, which stay, and has its doubt", async () => {
  localStorage.clear();
  const pull = { begin: 1, end: 9, speed_from: "FREQ", per_1000: 23, slip: 0.2, slips: true, points: [point(2500, 50), point(5000, 101)] };
  location.hash = "#/recordings/trip/drive.pcapng";
  const answers = {
    "/recordings/drive.pcapng/pulls": { pulls: [pull] },
    "/recordings/drive.pcapng/trip": whole,
    "/recordings": { recordings: [] },
  };
  const { asked, say, show } = page(answers);
  say();
  show(Screen, {});
  const button = await screen.findByRole<HTMLButtonElement>("button", { name: "Compute" });
  expect(button.disabled).toBe(true);
  await fireEvent.input(screen.getByLabelText(/^Mass/), { target: { value: "1600" } });
  await fireEvent.input(screen.getByLabelText(/^Speed at 1000/), { target: { value: "23,5" } });
  await fireEvent.click(button);
  await screen.findByText("101 ± 4 kW (137 hp) at 5000 rpm, 180 ± 8 Nm at 2500 rpm");
  expect(document.body.textContent).toContain("The gear seems to change by 20 %");
  expect(asked.at(-1)!.path).toBe("/recordings/drive.pcapng/pulls?mass=1600&per_1000=23.5&drag_area=0.9&slope=0");
  await waitFor(() => expect(localStorage.getItem("mikas.pulls")).not.toBeNull());
  expect(JSON.parse(localStorage.getItem("mikas.pulls")!)).toEqual({ "recording drive.pcapng": ["1600", "23,5", "0.9", "0"] });
});

it("the figures of a pull are those of its car", async () => {
  localStorage.clear();
  location.hash = "#/recordings/trip/a.pcapng";
  const of = (id: string, plate: string) => ({
    ...{ id, date: 1, model: null, passport: null, virtual: false, events: [] },
    car: { car: "", plate, mileage: null, workshop: "" },
  });
  const list = [of("a.pcapng", "А123ВС52"), of("b.pcapng", "x777xx77"), of("c.pcapng", "a 123 bc 52")];
  const rig = page({
    ...Object.fromEntries(
      list.flatMap(({ id }) => [
        [`/recordings/${id}/pulls`, { pulls: [] }],
        [`/recordings/${id}/trip`, whole],
      ]),
    ),
    "/recordings": { recordings: list },
  });
  rig.say();
  rig.show(Screen, {});
  const mass = async () => (await screen.findByLabelText<HTMLInputElement>(/^Mass/)).value;
  await fireEvent.input(await screen.findByLabelText(/^Mass/), { target: { value: "1600" } });
  await fireEvent.click(await screen.findByRole("button", { name: "Compute" }));
  await waitFor(() => expect(localStorage.getItem("mikas.pulls")).toContain("plate A123BC52"));
  rig.stores.route.go("recordings", "trip", "b.pcapng");
  await waitFor(async () => expect(await mass()).toBe(""));
  rig.stores.route.go("recordings", "trip", "c.pcapng");
  await waitFor(async () => expect(await mass()).toBe("1600"));
});
