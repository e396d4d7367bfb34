// Over which time minimum and maximum were taken.
import { hourMinute } from "../../lib/i18n";
import type { Stores } from "../../stores";
import { t } from "./messages";

/** "since 12:05", or "of the whole recording"; empty before the first value. */
export function extremesSpan({ display, live }: Stores): string {
  if (display.source.kind === "recording") return t("wholeRecording");
  const from = live.extremesFrom;
  if (from === null) return "";
  return t("since", { time: hourMinute(live.wallTime(from)) });
}
