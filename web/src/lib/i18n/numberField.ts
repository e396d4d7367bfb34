// A number in a field: typed with a comma or a point, and with either minus sign.
import { language } from "./language.svelte";

/** The number as it is typed, with all of its digits: what is shown in a field is saved. */
export function fieldText(value: number): string {
  const text = String(value).replace(/^-/, "−");
  return language.code === "ru" ? text.replace(".", ",") : text;
}

/** The number; null for an empty field, undefined for anything else. */
export function parsedNumber(text: string): number | null | undefined {
  const plain = text.trim().replace(",", ".").replace("−", "-");
  if (plain === "") return null;
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) && Number.isFinite(Number(plain)) ? Number(plain) : undefined;
}
