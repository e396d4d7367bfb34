// What live values are compared with in the chart: the range of a reference, a stripe behind each trace. Remembered in this browser.
import { loadSetting, saveSetting } from "../../../../lib/platform/storage";
import { NO_BANDS, WARM_IDLE, ValueRanges } from "../../../../lib/recording/valueRanges.svelte";
import { t } from "./messages";
import type { Stores } from "../../../../stores";

const SETTING = "chart.reference";

/** A reference's name for a person; the virtual car's needs `computed` beside it. */
export const titleOf = (chosen: string) => (chosen === WARM_IDLE ? t("virtual") : `★ ${chosen}`);

export class Reference {
  /** A recording's id, or `WARM_IDLE`; null: off. */
  chosen = $state(loadSetting(SETTING) || null);

  readonly ranges: ValueRanges;

  private readonly shown = $derived.by(() => this.app.display.source.kind === "live" && this.chosen !== null);
  /** Empty in a recording: there a reference is drawn as a second line. */
  readonly bands = $derived.by(() => (this.shown ? this.ranges.bands : NO_BANDS));
  /** What the stripes are; empty: there are none. */
  readonly title = $derived(
    this.shown && this.bands.size > 0
      ? t("stripes", { title: titleOf(this.chosen!) }) + (this.chosen === WARM_IDLE ? ` (${t("computed")})` : "")
      : "",
  );

  constructor(private readonly app: Pick<Stores, "api" | "catalog" | "display" | "live">) {
    this.ranges = new ValueRanges(app, () => this.chosen);
  }

  choose(chosen: string | null): void {
    this.chosen = chosen;
    saveSetting(SETTING, chosen ?? "");
  }

  toggle(): void {
    this.choose(this.chosen === null ? WARM_IDLE : null);
  }
}
