import { fireEvent, screen, waitFor } from "@testing-library/svelte";
import { expect, it } from "vitest";
import { eachOnItsOwnPage, page } from "../../../test/pageRig";
import Toasts from "./Toasts.svelte";

eachOnItsOwnPage();
const shown = () => [...document.querySelectorAll(".toast p")].map((each) => each.textContent);

it("what can't be saved is said as soon as the program finds it out, until it is closed", async () => {
  const problems = [{ en: "cars.json: damaged.", ru: "cars.json: повреждено." }];
  const { asked, say, show } = page({ "/about": () => ({ problems }) });
  const asks = () => asked.filter(({ path }) => path === "/about").length;
  show(Toasts, {});
  await waitFor(() => expect(shown()).toEqual(["cars.json: damaged."]));
  say({ unkept: 0 });
  problems.push({ en: "Freeze frames can't be saved.", ru: "Стоп-кадры не сохраняются." });
  say({ unkept: 1 });
  await waitFor(() => expect(shown()).toEqual(["cars.json: damaged.", "Freeze frames can't be saved."]));
  say({ unkept: 1 });
  expect(asks()).toBe(2);
  await fireEvent.click(screen.getAllByRole("button", { name: "Close" })[0]!);
  expect(shown()).toEqual(["Freeze frames can't be saved."]);
});
