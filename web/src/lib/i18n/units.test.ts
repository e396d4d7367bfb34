import { afterEach, expect, it } from "vitest";
import { language } from "./language.svelte";
import { unitAfter } from "./units";

afterEach(() => (language.code = "en"));

it("a counted unit has the form of its number as it is shown, a symbol has one form", () => {
  const steps = { en: "steps", ru: "шаг" };
  const shown = () => [1, 31, 30.7, -32, 36, 11].map((value) => unitAfter(value, steps));
  expect(shown()).toEqual(["step", "steps", "steps", "steps", "steps", "steps"]);
  language.code = "ru";
  expect(shown()).toEqual(["шаг", "шаг", "шаг", "шага", "шагов", "шагов"]);
  expect(unitAfter(2.5, steps, 1)).toBe("шага");
  expect([1, 2].map((value) => unitAfter(value, { en: "rpm", ru: "об/мин" }))).toEqual(["об/мин", "об/мин"]);
  expect(unitAfter(1, undefined)).toBe("");
});
