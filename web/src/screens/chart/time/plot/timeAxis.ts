// Labels of the time axis: times of day; in a comparison the time since the start of each recording.
import { point } from "../../../../lib/i18n";

const STEPS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14_400];

const two = (part: number) => String(part).padStart(2, "0");

/** Times of day, with fractions when zoomed in. */
export function timesOfDay(splits: readonly number[], step: number): string[] {
  return splits.map((split) => {
    const date = new Date(split * 1000);
    const minutes = `${two(date.getHours())}:${two(date.getMinutes())}`;
    if (step >= 60) return minutes;
    const seconds = `${minutes}:${two(date.getSeconds())}`;
    return step >= 1
      ? seconds
      : `${seconds}${point()}${String(Math.round(date.getMilliseconds()))
          .padStart(3, "0")
          .slice(0, step >= 0.1 ? 1 : 3)}`;
  });
}

/** Format 1:05, −0:10, 1:02:00, with as many decimals as the step needs. */
export function elapsed(seconds: number, step: number): string {
  const decimals = step >= 1 ? 0 : step >= 0.1 ? 1 : 2;
  const tidy = Number(Math.abs(seconds).toFixed(decimals));
  const hours = Math.floor(tidy / 3600);
  const minutes = Math.floor((tidy % 3600) / 60);
  const rest = (tidy % 60)
    .toFixed(decimals)
    .padStart(decimals ? 3 + decimals : 2, "0")
    .replace(".", point());
  const sign = seconds < 0 && tidy > 0 ? "−" : "";
  return sign + (hours ? `${hours}:${two(minutes)}:${rest}` : `${minutes}:${rest}`);
}

/** An axis that counts from `zero`, with labels at round times. */
export function counted(zero: number) {
  return {
    incrs: STEPS,
    splits: (_: unknown, __: number, from: number, to: number, step: number): number[] => {
      const first = Math.ceil((from - zero) / step);
      const count = Math.max(0, Math.floor((to - zero) / step) - first + 1);
      return Array.from({ length: count }, (_, index) => zero + (first + index) * step);
    },
    values: (_: unknown, splits: number[], __: number, ___: number, step: number): string[] =>
      splits.map((split) => elapsed(split - zero, step)),
  };
}

/** Round times for an axis with at most `most` labels: of the day, or counted from `zero`. */
export function axisTimes(from: number, to: number, zero: number | null, most = 9): { time: number; text: string }[] {
  const step = [...STEPS, 28_800, 43_200].find((each) => (to - from) / each <= most) ?? 86_400 * Math.ceil((to - from) / 86_400 / most);
  // Times of day are round in local time.
  const origin = zero ?? new Date(from * 1000).getTimezoneOffset() * 60;
  const first = Math.ceil((from - origin) / step - 1e-9);
  const count = Math.max(0, Math.floor((to - origin) / step + 1e-9) - first + 1);
  const times = Array.from({ length: count }, (_, index) => origin + (first + index) * step);
  const texts = zero === null ? timesOfDay(times, step) : times.map((time) => elapsed(time - zero, step));
  return times.map((time, index) => ({ time, text: texts[index]! }));
}
