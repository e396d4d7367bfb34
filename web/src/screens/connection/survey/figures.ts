// Figures that a person types, and times as a person reads them.

/** The number in a field; null: it is empty. undefined: it is none from `low` to `high`. */
export function figureIn(text: string, low: number, high: number): number | null | undefined {
  const typed = text.trim().replace(",", ".");
  if (typed === "") return null;
  const figure = Number(typed);
  return figure >= low && figure <= high ? figure : undefined;
}

/** Seconds as the count of a unit: coarser the more there are. */
export function coarse(seconds: number): { n: number; unit: "left_s" | "left_min" } {
  return seconds < 90 ? { n: Math.max(5, Math.ceil(seconds / 5) * 5), unit: "left_s" } : { n: Math.round(seconds / 60), unit: "left_min" };
}

/** The address of a virtual car that does what a survey asks; each of its own, for one that was started before stands where it was left. */
export const virtualCar = () => `sim:?scenario=survey&seed=${Date.now() % 1_000_000}`;
