import { fireEvent, screen, waitFor } from "@testing-library/svelte";
import { flushSync } from "svelte";
import { expect, it } from "vitest";
import type { SurveyState } from "../../../lib/api/types";
import { eachOnItsOwnPage, page } from "../../../../test/pageRig";
import { coarse, figureIn } from "./figures";
import Screen from "./Screen.svelte";

eachOnItsOwnPage();
const words = (text: string) => ({ en: text, ru: text });
const IDLE: SurveyState = {
  ...{ phase: "idle", port: null, virtual: false, step: null, instruction: null, asked: null },
  ...{ found: 0, open: 0, left: null, consents: null, error: null, saved: null },
};
const RUNNING: SurveyState = {
  ...IDLE,
  ...{ phase: "running", port: "COM3", found: 12, open: 22, left: 95 },
  consents: { engine: true, passports: false, memory: false },
  step: { name: "codes", title: words("codes 00–FF"), regime: "standing", place: 3, steps: 29, done: 64, of: 256 },
};
const STOPPED: SurveyState = { ...IDLE, phase: "stopped", found: 12, open: 22, consents: RUNNING.consents };
const RESULT = {
  answers: [
    { id: "echo", clauses: ["D1"], verdict: "found", title: words("echo"), text: words("the adapter returns what was sent") },
    { id: "long", clauses: ["D11"], verdict: "not-asked", title: words("long lists"), text: words("it was ended before") },
  ],
  members: [
    { name: "unit.json", bytes: 21, text: '{"passports": null}' },
    { name: "capture.pcapng", bytes: 1234, text: null },
  ],
};
const SAVED = { name: "mikas-survey.zip", bytes: 200 };

function shown(state: SurveyState, port: string | null = "COM3") {
  const rig = page({
    "/survey/result": RESULT,
    "/survey/stop": STOPPED,
    "/survey/start": RUNNING,
    "/survey": state,
    "/ports": { ports: [] },
  });
  rig.say({ port, line: port === null ? "off" : "sampling" });
  rig.show(Screen, {});
  return rig;
}

async function press(name: string): Promise<void> {
  const button = await screen.findByRole("button", { name });
  await waitFor(() => expect(button).toHaveProperty("disabled", false));
  await fireEvent.click(button);
}
const sent = (rig: ReturnType<typeof shown>, path: string) => rig.asked.filter((each) => each.method !== "GET" && each.path === path);

it("consents are asked for, memory and passports with a yes of their own", async () => {
  const rig = shown(IDLE);
  await screen.findByText("Ignition ON, engine OFF.");
  expect(document.body.textContent).toContain("Nothing is written or erased");
  await fireEvent.input(screen.getByRole("textbox"), { target: { value: "99" } });
  expect(screen.getByRole("button", { name: "Start" })).toHaveProperty("disabled", true);
  await fireEvent.input(screen.getByRole("textbox"), { target: { value: "12,4" } });
  await fireEvent.click(screen.getByRole("checkbox", { name: /Keep the texts/ }));
  await press("Start");
  await waitFor(() => expect(sent(rig, "/survey/start")).toHaveLength(1));
  expect(sent(rig, "/survey/start")[0]!.body).toEqual({ port: "COM3", engine: true, passports: true, memory: false, voltmeter: 12.4 });
  await screen.findByText("Ignition on, engine off");
});

it("without a cable there is the virtual car", async () => {
  const rig = shown(IDLE, null);
  await screen.findByText(/No adapter is found/);
  expect(screen.getByRole("button", { name: "Start" })).toHaveProperty("disabled", true);
  await press("Try it on the virtual car");
  expect(sent(rig, "/survey/start")[0]!.body).toMatchObject({
    port: expect.stringMatching(/^sim:\?scenario=survey&seed=\d+$/),
    voltmeter: null,
  });
});

it("in a browser that asks for the cable, choosing it is the start", async () => {
  const rig = page({ "/survey/start": RUNNING, "/survey": IDLE, "/ports": { ports: [] } });
  rig.stores.host.choosePort = () => Promise.resolve("webserial:0403:6001");
  rig.say({ port: null, line: "off" });
  rig.show(Screen, {});
  await press("Choose the adapter and start");
  await waitFor(() => expect(sent(rig, "/survey/start")[0]?.body).toMatchObject({ port: "webserial:0403:6001" }));
  rig.stores.host.choosePort = null;
});

it("while it runs, what to do stands in large letters, with what is done and left", async () => {
  const rig = shown(RUNNING);
  await screen.findByText("Ignition on, engine off");
  expect(document.body.textContent).toContain("Step 4 of 29: codes 00–FF");
  expect(document.body.textContent).toContain("12 questions answered, 22 open; about 2 min of measuring left");
  expect(screen.getByRole("progressbar")).toHaveProperty("value", 3.25 / 29);
  await press("Stop");
  await screen.findByText("Stopped. What was measured is kept.");
  expect(sent(rig, "/survey/stop")).toHaveLength(1);
});

it("the instruction of the program comes before that of the step", async () => {
  shown({ ...RUNNING, instruction: words("START the engine now") });
  await screen.findByText("START the engine now");
  expect(screen.queryByText("Ignition on, engine off")).toBeNull();
  await screen.findByText(/Waiting for the car/);
});

it("a figure is asked for within its limits, and there may be none", async () => {
  const asked = {
    id: 7,
    kind: "number",
    name: "tachometer",
    text: words("how many rpm now?"),
    unit: words("rpm"),
    low: 200,
    high: 3000,
  } as const;
  const rig = shown({ ...RUNNING, asked });
  const field = await screen.findByRole("textbox", { name: "how many rpm now?" });
  await fireEvent.input(field, { target: { value: "5000" } });
  await screen.findByText("A number from 200 to 3000");
  expect(screen.getByRole("button", { name: "Enter" })).toHaveProperty("disabled", true);
  await fireEvent.input(field, { target: { value: "850" } });
  await press("Enter");
  await waitFor(() => expect(sent(rig, "/survey/answer")[0]?.body).toEqual({ id: 7, done: false, figure: 850 }));
  await press("There is none");
  await waitFor(() => expect(sent(rig, "/survey/answer")[1]?.body).toEqual({ id: 7, done: false, figure: null }));
});

it("what the unit does not show, the person says", async () => {
  const asked = { id: 2, kind: "ready", name: "", text: words("Stop the engine"), unit: words(""), low: 0, high: 0 } as const;
  const rig = shown({ ...RUNNING, asked });
  await press("Done");
  await waitFor(() => expect(sent(rig, "/survey/answer")[0]?.body).toEqual({ id: 2, done: true, figure: null }));
  await press("Can't be done");
  await waitFor(() => expect(sent(rig, "/survey/answer")[1]?.body).toEqual({ id: 2, done: false, figure: null }));
});

it("all that the file would hold is shown before it is saved; forgetting is asked for", async () => {
  const rig = shown({ ...STOPPED, error: { code: "LinkLost", ...words("The cable is gone"), sent: null, received: null } });
  await screen.findByText("the adapter returns what was sent");
  expect(document.body.textContent).toContain("The cable is gone");
  expect(document.body.textContent).toContain('{"passports": null}');
  expect(document.body.textContent).toContain("not asked");
  await press("Go on");
  await waitFor(() => expect(sent(rig, "/survey/start")[0]?.body).toMatchObject({ port: "COM3" }));
});

it("a survey of the virtual car goes on with a virtual car, whatever is connected, and says so", async () => {
  const rig = shown({ ...STOPPED, virtual: true });
  await screen.findByText(/This is the virtual car/);
  await press("Go on");
  await waitFor(() => expect(sent(rig, "/survey/start")[0]?.body).toMatchObject({ port: expect.stringMatching(/^sim:/) }));
});

it("nothing is forgotten without a second touch", async () => {
  const rig = shown({ ...STOPPED, phase: "finished" });
  await screen.findByText(/Thank you!/);
  expect(screen.queryByRole("button", { name: "Go on" })).toBeNull();
  await press("Forget it");
  expect(sent(rig, "/survey")).toHaveLength(0);
  await fireEvent.click((await screen.findAllByRole("button", { name: "Forget it" })).at(-1)!);
  await waitFor(() => expect(sent(rig, "/survey").map(({ method }) => method)).toEqual(["DELETE"]));
});

it("a saved file can be had, and it says where to send it", async () => {
  shown({ ...IDLE, saved: SAVED });
  await screen.findByText("Saved: mikas-survey.zip");
  expect(screen.getByRole("link", { name: "Download" }).getAttribute("download")).toBe("mikas-survey.zip");
  expect(screen.getByRole("link", { name: "github.com/mikas-diagnostics/mikas/issues" }).getAttribute("href")).toMatch(/^https:/);
});

it("figures are read with a comma or a point, and times are coarse", () => {
  expect(["", "12,4", " 12.4 ", "x", "5", "19", "1e1"].map((text) => figureIn(text, 6, 18))).toEqual([
    null,
    12.4,
    12.4,
    undefined,
    undefined,
    undefined,
    10,
  ]);
  expect([0, 31, 89, 95, 300].map((each) => coarse(each).n)).toEqual([5, 35, 90, 2, 5]);
});

it("a survey that could not begin says why, and can be started again", async () => {
  shown({ ...IDLE, error: { code: "NoResponse", sent: null, received: null, ...words("The unit does not answer. Is the ignition on?") } });
  await screen.findByText("The unit does not answer. Is the ignition on?");
  expect(document.body.textContent).not.toContain("is kept");
  expect(screen.getByRole("button", { name: "Start" })).toHaveProperty("disabled", false);
});

it("a survey that broke off says why, and how it goes on", async () => {
  shown({ ...STOPPED, error: { code: "LinkLost", sent: null, received: null, ...words("The adapter is gone.") } });
  await screen.findByText("The adapter is gone.");
  expect(document.body.textContent).toContain("press “Go on”");
  expect(await screen.findByRole("button", { name: "Go on" })).toBeTruthy();
});

it("a trial on the virtual car asks nobody to send its file", async () => {
  shown({ ...IDLE, virtual: true, saved: { ...SAVED, name: "virtual-survey.zip" } });
  await screen.findByText("Saved: virtual-survey.zip");
  expect(document.body.textContent).toContain("don't send the file");
  expect(screen.queryByText(/Send it with an issue/)).toBeNull();
});

/** The page is cut off from the program for a moment: a screen that was locked, a program that is busy. */
function cutOff({ stores }: ReturnType<typeof shown>) {
  for (const link of ["lost", "open"] as const) {
    stores.live.link = link;
    flushSync();
  }
}

it("what the owner allows and enters stays while the page is cut off, and holds for one survey", async () => {
  const rig = shown(IDLE);
  const passports = () => screen.getByRole<HTMLInputElement>("checkbox", { name: /the unit.s passports/ });
  await fireEvent.click(await screen.findByRole("checkbox", { name: /the unit.s passports/ }));
  await fireEvent.input(screen.getByLabelText(/voltmeter/i), { target: { value: "12.6" } });
  cutOff(rig);
  expect([passports().checked, screen.getByLabelText<HTMLInputElement>(/voltmeter/i).value]).toEqual([true, "12.6"]);
  await press("Start");
  await screen.findByRole("button", { name: "Stop" });
  expect(rig.stores.survey.entered).toMatchObject({ consents: { passports: false }, volts: "" });
});

it("a figure that is being typed stays while the page is cut off, and is gone with its question", async () => {
  const asked = { id: 4, kind: "number" as const, name: "battery", text: words("How many volts?"), unit: words("V"), low: 6, high: 18 };
  const rig = shown({ ...RUNNING, asked });
  const field = () => screen.getByLabelText<HTMLInputElement>("How many volts?");
  await fireEvent.input(await screen.findByLabelText("How many volts?"), { target: { value: "13.9" } });
  cutOff(rig);
  await screen.findByLabelText("How many volts?");
  expect(field().value).toBe("13.9");
  rig.stores.survey["take"]({ ...RUNNING, asked: { ...asked, id: 5 } });
  flushSync();
  expect(field().value).toBe("");
});
