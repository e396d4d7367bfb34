// The figures from which a pull of a car is computed, as they were typed: kept in this browser for each car.
import type { Recording } from "../api/types";
import { loadSetting, saveSetting } from "../platform/storage";
import { carKeys } from "./oneCar";

const KEY = "pulls";
const MOST_CARS = 50;

export const FIELDS = ["mass", "per_1000", "drag_area", "slope"] as const;
export type Figures = Record<(typeof FIELDS)[number], string>;

/** The cars of this browser, the last one written at the end. */
function kept(): [string, string[]][] {
  try {
    const found: unknown = JSON.parse(loadSetting(KEY) ?? "{}");
    if (found === null || typeof found !== "object") return [];
    const isFigures = (it: unknown): it is string[] =>
      Array.isArray(it) && it.length === FIELDS.length && it.every((each) => typeof each === "string");
    return Object.entries(found).filter((entry): entry is [string, string[]] => isFigures(entry[1]));
  } catch {
    return []; // of another program, or cut
  }
}

/** A recording of a car of which nothing is known has figures of its own. */
const keysOf = (id: string, recording: Recording | undefined) => [...(recording ? carKeys(recording) : []), `recording ${id}`];

/** The figures of that recording's car; undefined: none are kept. */
export function figuresOf(id: string, recording: Recording | undefined): Figures | undefined {
  const cars = new Map(kept());
  const found = keysOf(id, recording).find((key) => cars.has(key));
  const [mass, per_1000, drag_area, slope] = (found === undefined ? undefined : cars.get(found)) ?? [];
  if (mass === undefined || per_1000 === undefined || drag_area === undefined || slope === undefined) return undefined;
  return { mass, per_1000, drag_area, slope };
}

export function keepFigures(id: string, recording: Recording | undefined, figures: Figures): void {
  const key = keysOf(id, recording)[0]!;
  const others = kept().filter(([car]) => car !== key);
  const all = [...others, [key, FIELDS.map((each) => figures[each])]].slice(-MOST_CARS);
  saveSetting(KEY, JSON.stringify(Object.fromEntries(all)));
}
