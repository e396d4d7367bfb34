// The address of a virtual car that a person chooses, and the number of a blind one in an address.
import { number, unitAfter } from "../../../lib/i18n";
import type { VirtualDefect } from "../../../lib/api/types";

export type Kind = "sound" | "defect" | "blind" | "carburettor";

export interface Choice {
  kind: Kind;
  scenario: string;
  defect: Pick<VirtualDefect, "key"> | null;
  amount: number;
  number: number;
}

export function address({ kind, scenario, defect, amount, number: blind }: Choice): string {
  if (kind === "carburettor") return `sim:?scenario=${scenario}&model=5.4&ignition_only=yes`;
  const car = kind === "blind" ? `blind:${blind}` : kind === "defect" && defect ? `${defect.key}:${amount}` : "healthy";
  return `sim:?scenario=${scenario}&car=${car}`;
}

/** The `car` of an address if it is a blind one, as `blind:4711`. */
export function blindCar(port: string | null | undefined): string | null {
  return /^sim:\?(?:.*&)?car=(blind:\d+)(?:&|$)/.exec(port ?? "")?.[1] ?? null;
}

type Amounts = Pick<VirtualDefect, "sound" | "least" | "noticeable" | "most" | "percent" | "unit">;

/** The decimals of an amount on the slider. */
export function decimalsOf({ least, most, percent }: Pick<Amounts, "least" | "most" | "percent">): number {
  const span = Math.abs(most - least);
  return percent ? 2 : span >= 15 ? 0 : 1;
}

/** The amount at a place of the slider, 0 (hardly) to 100 (the most). */
export function amountAt(defect: Amounts, place: number): number {
  return Number((defect.least + ((defect.most - defect.least) * place) / 100).toFixed(decimalsOf(defect)));
}

export function placeOf({ least, most }: Amounts, amount: number): number {
  return Math.round(((amount - least) / (most - least)) * 100);
}

/** The number of an amount as it is read: a share in percent. */
export function amountText(defect: Amounts, amount: number): string {
  const decimals = decimalsOf(defect);
  const shown = defect.percent ? number(amount * 100, 0) : number(amount, decimals);
  const unit = unitAfter(defect.percent ? amount * 100 : amount, defect.unit, defect.percent ? 0 : decimals);
  return unit === "°" ? `${shown}°` : `${shown}\u00a0${unit}`;
}
