// Numbers, times and sizes in the format of the selected language; numbers as they are typed, with a comma or a point and either minus sign.
import { language, type Code } from "./language.svelte";

const locales: Record<Code, string> = { en: "en-GB", ru: "ru-RU" };
const made = new Map<string, Intl.NumberFormat>();

/** Shown when there is no number. */
export const DASH = "–";

/** Format a number with `decimals` digits; without `decimals`, with as many as it has, at most three. */
export function number(value: number | null | undefined, decimals?: number): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return DASH;
  const key = `${language.code}${decimals ?? ""}`;
  let format = made.get(key);
  if (!format) {
    format = new Intl.NumberFormat(locales[language.code], {
      useGrouping: false,
      minimumFractionDigits: decimals ?? 0,
      maximumFractionDigits: decimals ?? 3,
    });
    made.set(key, format);
  }
  const text = format.format(value).replace("-", "−");
  return /^−[0.,]*$/.test(text) ? text.slice(1) : text;
}

/** A difference, with its sign; none for one that is shown as 0. */
export function signed(value: number, decimals?: number): string {
  const text = number(value, decimals);
  return value > 0 && /[1-9]/.test(text) ? `+${text}` : text;
}

export function percent(share: number, decimals = 0): string {
  return `${number(share * 100, decimals)} %`;
}

/** What stands before the decimals of a time: 13:37:27.5, 13:37:27,5. */
export const point = (): string => (language.code === "ru" ? "," : ".");

/** Format a duration: 12:41 or 1:12:41. */
export function clock(seconds: number | null | undefined): string {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return DASH;
  const whole = Math.max(0, Math.floor(seconds));
  const two = (part: number) => String(part).padStart(2, "0");
  const minutes = Math.floor(whole / 60);
  if (minutes < 60) return `${two(minutes)}:${two(whole % 60)}`;
  return `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${two(whole % 60)}`;
}

const steps: Record<Code, string[]> = { en: ["B", "KB", "MB", "GB"], ru: ["Б", "КБ", "МБ", "ГБ"] };

export function size(bytes: number): string {
  let step = 0;
  let left = bytes;
  while (left >= 1000 && step < 3) {
    left /= 1000;
    step += 1;
  }
  return `${number(left, step === 0 || left >= 100 ? 0 : 1)} ${steps[language.code][step]}`;
}

/** Format UNIX seconds as local date and time. */
export function moment(time: number | null | undefined): string {
  if (time === null || time === undefined) return DASH;
  return new Date(time * 1000).toLocaleString(locales[language.code], { dateStyle: "medium", timeStyle: "short" });
}

/** Format UNIX seconds as local time with seconds. */
export function timeOfDay(time: number): string {
  return new Date(time * 1000).toLocaleTimeString(locales[language.code]);
}

/** Format UNIX seconds as local time without seconds. */
export function hourMinute(time: number): string {
  return new Date(time * 1000).toLocaleTimeString(locales[language.code], { hour: "2-digit", minute: "2-digit" });
}

/** Format an address or a code: 0x00A7. */
export function hex(value: number, digits = 4): string {
  return `0x${value.toString(16).toUpperCase().padStart(digits, "0")}`;
}

/** Insert spaces between bytes: "01F9A0" → "01 F9 A0". */
export function spaced(bytes: string): string {
  return bytes.replace(/(..)(?=.)/g, "$1 ");
}

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
