// Which recordings may be of one car, by what the list has of them. The program looks at the whole files, and refuses another car's.
import type { Recording } from "../api/types";

type Known = Pick<Recording, "car" | "model" | "passport" | "virtual">;

const LATIN: Record<string, string> = { А: "A", В: "B", Е: "E", К: "K", М: "M", Н: "H", О: "O", Р: "P", С: "C", Т: "T", У: "Y", Х: "X" };
const plate = (text: string) =>
  text
    .toUpperCase()
    .replace(/[\s-]/g, "")
    .replace(/[А-Я]/g, (letter) => LATIN[letter] ?? letter);
const words = (text: string) => text.toLowerCase().split(/\s+/).filter(Boolean).join(" ");

/** The names by which figures of a recording's car are kept, the surest first; none: nothing is known of it. */
export function carKeys({ car, passport, virtual }: Pick<Known, "car" | "passport" | "virtual">): string[] {
  const keys = [];
  if (car.plate) keys.push(`plate ${plate(car.plate)}`);
  if (car.car) keys.push(`car ${words(car.car)}`);
  if (passport?.some(Boolean)) keys.push(`unit ${passport.join("/")}`);
  return virtual ? keys.map((key) => `virtual ${key}`) : keys;
}

/** Whether two recordings may be of one car, and of one unit: nothing that is known of both differs. */
export function mayBeOneCar(one: Known, other: Known): boolean {
  if (one.virtual !== other.virtual) return false;
  if (one.model && other.model && one.model.en !== other.model.en) return false;
  if (one.car.plate && other.car.plate) return plate(one.car.plate) === plate(other.car.plate);
  if (one.car.car && other.car.car) return words(one.car.car) === words(other.car.car);
  if (!one.passport || !other.passport) return true;
  return one.passport.every((piece, at) => !piece || !other.passport?.[at] || piece === other.passport[at]);
}
