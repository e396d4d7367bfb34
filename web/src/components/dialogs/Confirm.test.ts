import { fireEvent, render, screen } from "@testing-library/svelte";
import { createRawSnippet } from "svelte";
import { expect, it, vi } from "vitest";
import { eachOnItsOwnPage } from "../../../test/pageRig";
import Confirm from "./Confirm.svelte";

eachOnItsOwnPage();

function dialog(more: object = {}) {
  const [onconfirm, onclose] = [vi.fn(), vi.fn()];
  const children = createRawSnippet(() => ({ render: () => "<p>Two faults are lost</p>" }));
  render(Confirm, { title: "Erase?", verb: "Erase", onconfirm, onclose, children, ...more });
  return { onconfirm, onclose };
}

it("the question, what will happen and both answers are there; the safe one comes first", () => {
  dialog();
  expect(screen.getByRole("dialog", { name: "Erase?" }).textContent).toContain("Two faults are lost");
  const answers = screen.getAllByRole("button").map((button) => button.textContent.trim());
  expect(answers.filter(Boolean)).toEqual(["Cancel", "Erase"]);
});

it("each answer calls what it says", async () => {
  const { onconfirm, onclose } = dialog();
  await fireEvent.click(screen.getByRole("button", { name: "Cancel" }));
  expect([onclose.mock.calls.length, onconfirm.mock.calls.length]).toEqual([1, 0]);
  await fireEvent.click(screen.getByRole("button", { name: "Erase" }));
  expect(onconfirm).toHaveBeenCalledOnce();
});

it("while it runs it can't be confirmed again", () => {
  dialog({ busy: true });
  expect(screen.getByRole<HTMLButtonElement>("button", { name: "Erase" }).disabled).toBe(true);
});
