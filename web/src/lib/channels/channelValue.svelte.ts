// The current value of a channel as tiles show it: text, age, extremes, and whether it is beyond a limit.
import { useStores } from "../../stores";
import { frameClock } from "../platform/frameClock.svelte";
import type { DisplayValue } from "./displayValue";
import { number, localized } from "../i18n";
import type { Extremes } from "../series/columns";
import { widestText } from "./textWidth";
import { valueText, wordsOf } from "./valueText";
import type { Channel, Level } from "../api/types";

export interface LimitState {
  level: Level;
  side: "low" | "high";
}

/** To be made while a component is initialised. */
export class ChannelValue {
  private readonly stores = useStores();
  readonly channel = $derived.by(() => this.stores.catalog.get(this.name()));
  readonly now = $derived.by<DisplayValue>(() => frameClock.eachFrame(() => this.stores.display.value(this.name())));
  readonly kind = $derived(this.now.kind);
  readonly value = $derived(this.now.kind === "none" ? null : this.now.value);
  readonly age = $derived(this.now.kind === "stale" ? number(this.now.age, this.now.age < 10 ? 1 : 0) : "");
  readonly text = $derived(number(this.value, this.channel?.decimals ?? 0));
  /** The two words of a flag. */
  readonly words = $derived(wordsOf(this.channel));
  /** The value as it is read: a word for a flag, else the number. */
  readonly shown = $derived(valueText(this.channel, this.value));
  /** The widest that `shown` becomes, in em. */
  readonly em = $derived(widestText(this.channel, this.words, this.shown));
  readonly title = $derived.by(() => (this.channel ? localized(this.channel.text) : this.name()));
  /** The title where there is little room: tiles and legends. */
  readonly short = $derived.by(() => (this.channel ? localized(this.channel.short) : this.name()));
  readonly unit = $derived(localized(this.channel?.unit));
  readonly extremes = $derived.by<Extremes | undefined>(() => {
    const extremes = frameClock.slowly(() => this.stores.display.source.extremes(this.name()));
    return extremes && { ...extremes };
  });
  // The value changes in each frame, the extremes with the slow clock: without the value they would contradict it.
  private readonly lowest = $derived(this.extremes && Math.min(this.extremes.min, this.value ?? Infinity));
  private readonly highest = $derived(this.extremes && Math.max(this.extremes.max, this.value ?? -Infinity));
  readonly min = $derived(this.lowest === undefined ? "" : number(this.lowest, this.channel?.decimals));
  readonly max = $derived(this.highest === undefined ? "" : number(this.highest, this.channel?.decimals));
  readonly limitState = $derived.by<LimitState | null>(() => {
    if (this.value === null || !this.channel) return null;
    // Live, the program decides, with hysteresis; for a recording and a frozen view the page compares with the limits.
    if (this.stores.display.source.kind === "live" && !this.stores.display.source.paused) {
      const alarm = this.stores.live.state?.alarms.find(({ name }) => name === this.name());
      return alarm ? { level: alarm.level, side: alarm.side } : null;
    }
    return limitState(this.value, this.channel);
  });
  readonly level = $derived(this.limitState?.level ?? null);
  /** Of a flag that is on and means trouble: the level at which it alarms, or the colour that the catalog gives it without an alarm. */
  readonly trouble = $derived.by<Level | null>(() => {
    if (!this.channel || !this.value) return null;
    const { alarm_when_true: alarm, lamp } = this.channel;
    const level = alarm === "none" ? lamp?.trouble : alarm;
    return level && level !== "none" ? level : null;
  });

  constructor(private readonly name: () => string) {}
}

/** Which limit the value is beyond, if any. */
export function limitState(value: number, channel: Channel): LimitState | null {
  if (channel.flag) {
    if (channel.alarm_when_true === "none" || !value) return null;
    return { level: channel.alarm_when_true, side: "high" };
  }
  const limits = channel.limits;
  if (!limits) return null;
  if (limits.danger_low !== null && value < limits.danger_low) return { level: "danger", side: "low" };
  if (limits.danger_high !== null && value > limits.danger_high) return { level: "danger", side: "high" };
  if (limits.warning_low !== null && value < limits.warning_low) return { level: "warning", side: "low" };
  if (limits.warning_high !== null && value > limits.warning_high) return { level: "warning", side: "high" };
  return null;
}
