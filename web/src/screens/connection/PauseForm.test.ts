import { fireEvent, screen } from "@testing-library/svelte";
import { flushSync } from "svelte";
import { expect, it, vi } from "vitest";
import { eachOnItsOwnPage, page } from "../../../test/pageRig";
import type { State } from "../../lib/api/types";
import PauseForm from "./PauseForm.svelte";

eachOnItsOwnPage();

const plan = { wanted: [], first: [], method: "stream", rate: 5 } as State["plan"];

function form(pause: State["pause"], disabled = false) {
  const shown = page({ "/connect": { line: "sampling", port: "COM3", plan, pause: { chosen: 0.12, seconds: 0.12 } } });
  shown.say({ port: "COM3", plan, pause });
  shown.show(PauseForm, { disabled });
  flushSync();
  return shown;
}
const summary = () => document.querySelector("summary")!.textContent;
const button = (name: string) => screen.getByRole<HTMLButtonElement>("button", { name, hidden: true });
const field = () => document.querySelector<HTMLInputElement>("input");
const sent = ({ asked }: ReturnType<typeof form>) => asked.filter(({ method }) => method === "POST").map(({ path, body }) => [path, body]);

it.each([
  [null, "not known yet"],
  [{ chosen: null, seconds: null }, "not known yet"],
  [{ chosen: null, seconds: 0 }, "this unit needs none"],
  [{ chosen: null, seconds: 0.025 }, "25 ms, found by trying"],
  [{ chosen: 0.1, seconds: 0.1 }, "100 ms, as set"],
  [{ chosen: 0, seconds: null }, "0 ms, as set"],
])("the line says which pause is kept: %o", (pause, said) => {
  form(pause);
  expect(summary()).toBe(`Pause before a request: ${said}`);
});

it("a pause of one's own begins with the one found, and goes to the program in seconds, with the plan of now", async () => {
  const shown = form({ chosen: null, seconds: 0.025 });
  expect(field()).toBeNull();
  await fireEvent.click(button("My own"));
  expect(field()!.value).toBe("25");
  await fireEvent.input(field()!, { target: { value: "120" } });
  await fireEvent.click(button("Set the pause"));
  expect(sent(shown)).toEqual([["/connect", { port: "COM3", echo: "auto", method: "stream", rate: 5, pause: 0.12 }]]);
  await vi.waitFor(() => expect(summary()).toContain("120 ms, as set"));
  flushSync();
  expect(field()!.value).toBe("120");
});

it("it is found by trying again", async () => {
  const shown = form({ chosen: 0.1, seconds: 0.1 });
  await fireEvent.click(button("By itself"));
  await fireEvent.click(button("Set the pause"));
  expect(sent(shown)).toMatchObject([["/connect", { pause: "auto" }]]);
});

it.each(["2001", "-1", "0,1", "", "soon"])("%o is no pause, and says so", async (text) => {
  form({ chosen: 0.1, seconds: 0.1 });
  await fireEvent.input(field()!, { target: { value: text } });
  expect(document.body.textContent).toContain("A whole number from 0 to 2000.");
  expect(button("Set the pause").disabled).toBe(true);
});

it("who may not connect can set none", () => {
  form({ chosen: null, seconds: 0 }, true);
  expect(button("Set the pause").disabled).toBe(true);
});

it("what is pressed before the answer has come is the next wish", async () => {
  const shown = form({ chosen: null, seconds: 0 });
  await fireEvent.click(button("My own"));
  await fireEvent.input(field()!, { target: { value: "70" } });
  await Promise.all([fireEvent.click(button("Set the pause")), fireEvent.click(button("By itself"))]);
  await vi.waitFor(() => expect(summary()).toContain("120 ms, as set"));
  await vi.waitFor(() => expect(button("Set the pause").disabled).toBe(false));
  await fireEvent.click(button("Set the pause"));
  expect(sent(shown)).toMatchObject([
    ["/connect", { pause: 0.07 }],
    ["/connect", { pause: "auto" }],
  ]);
});
