// What was lost while the page was not shown: a phone's call, another app, a page that the browser has frozen. Sampling goes on meanwhile as far as the
// phone lets it. On return the values that are missing are said once, for a chart of another minute does not show them.
import { clock, dictionary, number } from "../i18n";
import type { LineEvent } from "../api/types";
import type { Stores } from "../../stores";

const t = dictionary({
  lost: { en: "While the page was in the background no values came for {time}.", ru: "Пока страница была в фоне, данных не было {time}." },
  seconds: { en: "{n} s", ru: "{n} с" },
  goes_on: { en: "The recording goes on, with a gap.", ru: "Запись идёт, в ней пропуск." },
  ended: { en: "The recording has ended: {file}.", ru: "Запись закончилась: {file}." },
});

/** s: a shorter loss is not worth a message. */
const LEAST = 2;
/** ms after the return, in which the program says what has happened. */
const SETTLED_MS = 1500;

/** Code of the message. */
const CODE = "LostMeanwhile";

/** Seconds without values between two times of the program's clock, by its gaps; the one that goes on ends with `to`. */
export function lostBetween(events: readonly LineEvent[], from: number, to: number): number {
  let lost = 0;
  let until = from;
  const gaps = events.flatMap((event) => (event.kind === "gap" ? [{ began: event.began, ended: event.ended ?? to }] : []));
  for (const { began, ended } of gaps.sort((a, b) => a.began - b.began)) {
    lost += Math.max(0, Math.min(ended, to) - Math.max(began, until));
    until = Math.max(until, ended);
  }
  return lost;
}

export class WhileAway {
  /** When the page was hidden, in the program's seconds, and what it recorded then; null: it is shown, or nothing came. */
  private left: { at: number; later: number; file: string | null } | null = null;

  constructor(private readonly app: Pick<Stores, "live" | "toasts">) {}

  /** Follow the page from now on. Returns what ends that. */
  watch(): () => void {
    let timer: ReturnType<typeof setTimeout> | undefined;
    const turn = () => {
      clearTimeout(timer);
      if (document.hidden) this.hide();
      else if (this.left) timer = setTimeout(() => this.back(), SETTLED_MS);
    };
    document.addEventListener("visibilitychange", turn);
    return () => {
      clearTimeout(timer);
      document.removeEventListener("visibilitychange", turn);
    };
  }

  hide(): void {
    const { live } = this.app;
    if (this.left !== null || live.link !== "open" || live.state?.line !== "sampling") return;
    this.left = { at: live.now(), later: live.later, file: live.state.recording?.file ?? null };
  }

  back(): void {
    const { live, toasts } = this.app;
    const { left } = this;
    this.left = null;
    // A program that is gone is said in the band.
    if (left === null || live.link === "lost" || live.state === null) return;
    const lost = lostBetween(live.events, left.at + live.later - left.later, live.now());
    const { file } = left;
    const ended = file !== null && live.state.recording?.file !== file;
    if (lost < LEAST && !ended) return;
    const text = () =>
      [
        lost < LEAST ? "" : t("lost", { time: lost < 60 ? t("seconds", { n: number(lost, 0) }) : clock(lost) }),
        file === null ? "" : ended ? t("ended", { file }) : t("goes_on"),
      ]
        .filter(Boolean)
        .join(" ");
    toasts.refuse(text, { code: CODE, duration: Infinity });
  }
}
