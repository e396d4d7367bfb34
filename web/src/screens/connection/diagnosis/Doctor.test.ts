// The button beside a failed connection: what it asks the program for, and when it is there.
import { fireEvent, screen } from "@testing-library/svelte";
import { flushSync } from "svelte";
import { expect, it } from "vitest";
import type { DoctorStep } from "../../../lib/api/types";
import { eachOnItsOwnPage, page } from "../../../../test/pageRig";
import Doctor from "./Doctor.svelte";

eachOnItsOwnPage();

const both = (text: string) => ({ en: text, ru: text });
const step = (name: string, ok: boolean | null, detail = name): DoctorStep => ({
  name,
  ok,
  code: null,
  port: "COM3",
  title: both(name),
  detail: both(detail),
  to_try: null,
});
const SILENT = [step("port", true), step("echo", true), step("ecu", false)];
const button = () => screen.queryByRole("button", { name: "Another kind of unit?" });

it("a cable that works with nothing at its end: another kind of unit is looked for on request, and named", async () => {
  const shown = page();
  const asked: unknown[] = [];
  const { connection } = shown.stores;
  shown.stores.api.doctor = (port, onStep, others) => {
    asked.push([port, others ?? false]);
    for (const each of SILENT) onStep(each);
    if (others) onStep(step("kwp2000-fast", true, "this unit speaks KWP2000"));
    return Promise.resolve();
  };
  shown.show(Doctor, { allowed: true, port: "COM3", outdated: false });
  expect(button()).toBe(null); // nothing was checked yet
  await connection.examine("COM3");
  flushSync();
  await fireEvent.click(button()!);
  await Promise.resolve();
  flushSync();
  expect(asked).toEqual([
    ["COM3", false],
    ["COM3", true],
  ]);
  expect(screen.getByText("this unit speaks KWP2000")).toBeTruthy();
  expect(screen.getByText("KWP2000, fast wake-up")).toBeTruthy();
  expect(button()).toBe(null); // it was done
});

it("not where a Mikas answers, nor where the port can't be opened", async () => {
  const shown = page();
  const { connection } = shown.stores;
  let steps = [step("port", true), step("echo", true), step("ecu", true), step("commands", true)];
  shown.stores.api.doctor = (_port, onStep) => {
    for (const each of steps) onStep(each);
    return Promise.resolve();
  };
  shown.show(Doctor, { allowed: true, port: "COM3", outdated: false });
  for (const found of [steps, [step("port", false)]]) {
    steps = found;
    await connection.examine("COM3");
    flushSync();
    expect(button()).toBe(null);
  }
});
