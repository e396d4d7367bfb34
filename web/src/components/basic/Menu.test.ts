import { fireEvent, render, screen } from "@testing-library/svelte";
import { expect, it, vi } from "vitest";
import { eachOnItsOwnPage } from "../../../test/pageRig";
import Menu from "./Menu.svelte";

eachOnItsOwnPage();
const commands = () => [
  { text: "Statistics…", run: vi.fn() },
  { text: "Stacked", on: true, run: vi.fn() },
];
const opener = () => screen.getByRole("button", { name: "More" });
const opened = () => opener().getAttribute("aria-expanded") === "true";

it("a chosen command runs, and the menu closes", async () => {
  const all = commands();
  render(Menu, { label: "More", commands: all });
  await fireEvent.click(opener());
  await fireEvent.click(screen.getByRole("button", { name: "Statistics…" }));
  expect(all[0]!.run).toHaveBeenCalledOnce();
  expect(opened()).toBe(false);
});

it("a switch says whether it is on", async () => {
  render(Menu, { label: "More", commands: commands() });
  await fireEvent.click(opener());
  expect(screen.getByRole("button", { name: "Stacked" }).getAttribute("aria-pressed")).toBe("true");
});

it("the arrows go round, Escape and a click outside close it", async () => {
  render(Menu, { label: "More", commands: commands() });
  await fireEvent.click(opener());
  await fireEvent.keyDown(opener(), { key: "ArrowUp" });
  expect(document.activeElement?.textContent).toContain("Stacked");
  await fireEvent.keyDown(document.activeElement!, { key: "ArrowDown" });
  expect(document.activeElement?.textContent).toContain("Statistics");
  await fireEvent.keyDown(document.activeElement!, { key: "Escape" });
  expect([opened(), document.activeElement === opener()]).toEqual([false, true]);
  await fireEvent.click(opener());
  await fireEvent.pointerDown(document.body);
  expect(opened()).toBe(false);
});
