// Numbers, times and sizes as they are written in the language on the screen.
import { language, type Code } from "./language.svelte";

const locales: Record<Code, string> = { en: "en-GB", ru: "ru-RU" };
const made = new Map<string, Intl.NumberFormat>();

/** No number: a dash, never a guess. */
export const DASH = "–";

/** With a fixed number of decimals; without them: as many as it has, at most three. */
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

export function percent(share: number, decimals = 0): string {
  return `${number(share * 100, decimals)} %`;
}

/** 12:41 or 1:12:41. */
export function clock(seconds: number | null | undefined): string {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return DASH;
  const whole = Math.max(0, Math.floor(seconds));
  const two = (part: number) => String(part).padStart(2, "0");
  const minutes = Math.floor(whole / 60);
  if (minutes < 60) return `${two(minutes)}:${two(whole % 60)}`;
  return `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${two(whole % 60)}`;
}

const steps: Record<Code, string[]> = {
  en: ["B", "KB", "MB", "GB"],
  ru: ["Б", "КБ", "МБ", "ГБ"],
};

export function size(bytes: number): string {
  let step = 0;
  let left = bytes;
  while (left >= 1000 && step < 3) {
    left /= 1000;
    step += 1;
  }
  return `${number(left, step === 0 || left >= 100 ? 0 : 1)} ${steps[language.code][step]}`;
}

/** UNIX seconds as a date and a time of day here. */
export function moment(time: number | null | undefined): string {
  if (time === null || time === undefined) return DASH;
  return new Date(time * 1000).toLocaleString(locales[language.code], {
    dateStyle: "medium",
    timeStyle: "short",
  });
}

/** Time of day, to the second. */
export function timeOfDay(time: number): string {
  return new Date(time * 1000).toLocaleTimeString(locales[language.code]);
}

/** 0x00A7: an address or a code. */
export function hex(value: number, digits = 4): string {
  return `0x${value.toString(16).toUpperCase().padStart(digits, "0")}`;
}

/** "01F9A0" as "01 F9 A0". */
export function spaced(bytes: string): string {
  return bytes.replace(/(..)(?=.)/g, "$1 ");
}
