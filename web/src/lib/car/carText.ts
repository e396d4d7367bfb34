// A car's details as typed, and on one line.
import type { Car } from "../api/types";

const MOST_MILEAGE = 9_999_999;

/** Car and plate on one line; empty without them. */
export const carName = ({ car, plate }: Pick<Car, "car" | "plate">): string => [car, plate].filter(Boolean).join(" · ");

/** A mileage as typed, with spaces between thousands or without; null: none. Undefined: not a number of km. */
export function parseMileage(typed: string): number | null | undefined {
  const digits = typed.replace(/[\s.,]|km|км/gi, "");
  if (digits === "") return null;
  if (!/^\d{1,9}$/.test(digits)) return undefined;
  const km = Number(digits);
  return km <= MOST_MILEAGE ? km : undefined;
}
