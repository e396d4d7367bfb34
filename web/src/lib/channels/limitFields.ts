// Limits and scales as a person types them: texts, until they are saved.
import { fieldText, parsedNumber } from "../i18n";
import type { Channel, NewLimits } from "../api/types";

export const LIMITS = ["danger_low", "warning_low", "warning_high", "danger_high"] as const;
export type LimitTexts = Record<(typeof LIMITS)[number] | "hysteresis", string>;

const text = (value: number | null | undefined) => (value === null || value === undefined ? "" : fieldText(value));

export function limitTexts(limits: Channel["limits"]): LimitTexts {
  return {
    danger_low: text(limits?.danger_low),
    warning_low: text(limits?.warning_low),
    warning_high: text(limits?.warning_high),
    danger_high: text(limits?.danger_high),
    hysteresis: text(limits?.hysteresis || null),
  };
}

export const endTexts = (ends: readonly [number, number] | null | undefined): [string, string] => [text(ends?.[0]), text(ends?.[1])];

/** The first text that is not a number; undefined if all are, or are empty. */
export const notNumber = (texts: readonly string[]): string | undefined => texts.find((each) => parsedNumber(each) === undefined);

/** The limits to save; the texts are numbers or empty. */
export function limitsOf(texts: LimitTexts): NewLimits {
  const limits = Object.fromEntries(LIMITS.map((key) => [key, parsedNumber(texts[key]) ?? null]));
  return { ...limits, hysteresis: parsedNumber(texts.hysteresis) ?? 0, when_true: "none" };
}

/** Both ends, null if both are empty; undefined if one is missing. */
export function endsOf([low, high]: readonly [string, string]): [number, number] | null | undefined {
  const [first, last] = [parsedNumber(low) ?? null, parsedNumber(high) ?? null];
  if (first === null && last === null) return null;
  return first === null || last === null ? undefined : [first, last];
}
