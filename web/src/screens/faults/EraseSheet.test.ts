import { screen } from "@testing-library/svelte";
import { expect, it } from "vitest";
import { eachOnItsOwnPage, page } from "../../../test/pageRig";
import EraseSheet from "./EraseSheet.svelte";

eachOnItsOwnPage();
const words = (text: string) => ({ en: text, ru: text });
const proposal = {
  ...{ nonce: "n", expires: 1e12, what: words("erase 1 stored fault"), before: [13], after: [] },
  ...{ danger: false, lost: [{ en: "Air mass signal low", ru: "", code: 13 }], meaning: null },
};

async function asked(more: object) {
  const { say, show } = page({ "/changes": { ...proposal, ...more } });
  say();
  show(EraseSheet, { stored: [], onclose: () => undefined, ondone: () => undefined });
  await screen.findByText("13 · Air mass signal low");
}

it("an erase names the faults that are lost", async () => {
  await asked({});
  expect(screen.getByRole("button", { name: "Erase" })).toBeTruthy();
});

it("an erase with the engine running says so, on its button too", async () => {
  await asked({ danger: true, meaning: words("The engine is running (840 rpm).") });
  expect(screen.getByText("The engine is running (840 rpm).")).toBeTruthy();
  expect(screen.queryByRole("button", { name: "Erase" })).toBeNull();
  expect(screen.getByRole("button", { name: "Erase with the engine running" })).toBeTruthy();
});
