// A unit as it stands after a number: 31 шаг, 32 шага, 2,5 шага. Most units are symbols and stay as they are: V, об/мин.
import { dictionary } from "./dictionary";
import { localized } from "./language.svelte";

type Unit = Parameters<typeof localized>[0];

const counted = dictionary({
  steps: { en: { one: "step", other: "steps" }, ru: { one: "шаг", few: "шага", many: "шагов", other: "шага" } },
});

/** The unit after a number that is `shown` with so many decimals; a value of 30.7 is shown as 31. */
export function unitAfter(value: number, unit: Unit, decimals = 0): string {
  return unit?.en === "steps" ? counted("steps", { n: Math.abs(Number(value.toFixed(decimals))) }) : localized(unit);
}
