// A message on every screen when the unit stores another fault.
import type { Stores } from "../../stores";
import { dictionary } from "../i18n";
import type { LineEvent } from "../api/types";

/**
 * The latest event about faults, unless that is `seen`; null: none, or faults have only gone. Not compared by their times: a virtual car has
 * another clock.
 */
export function faultNews(events: readonly LineEvent[], seen: LineEvent | null) {
  const event = events.findLast((event) => event.kind === "faults");
  return event !== seen && event?.added?.length ? event : null;
}

const t = dictionary({
  added: { en: "New fault in the unit: {codes}", ru: "Новая ошибка в памяти блока: {codes}" },
  show: { en: "Show", ru: "Показать" },
});

/** s: an older event was news for an earlier page. */
const RECENT = 10;

/** Tell what is new among the events. Returns a function to be called with all of them after each change. */
export function faultTeller({ live, route, toasts }: Pick<Stores, "live" | "route" | "toasts">) {
  let seen: LineEvent | null = null;
  return (events: readonly LineEvent[]): void => {
    const news = faultNews(events, seen);
    if (!news) return;
    seen = news;
    if (live.now() - news.time > RECENT) return;
    const codes = news.added?.join(", ") ?? "";
    const action = { text: () => t("show"), run: () => route.go("faults") };
    toasts.error(() => t("added", { codes }), { duration: 12_000, action });
  };
}
