// Over which time minimum and maximum were taken.
import { hourMinute } from "../../lib/i18n";
import { live } from "../../lib/live/live.svelte";
import { display } from "../../lib/display/source.svelte";
import { t } from "./messages";

/** "since 12:05", or "of the whole recording"; empty before the first value. */
export function extremesSpan(): string {
  if (display.source.kind === "recording") return t("wholeRecording");
  const from = live.extremesFrom;
  if (from === null) return "";
  return t("since", { time: hourMinute(live.wallTime(from)) });
}
