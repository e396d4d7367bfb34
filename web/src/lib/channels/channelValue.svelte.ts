// The current value of a channel as tiles show it: text, age, extremes, and whether it is beyond a limit.
import { useStores } from "../../stores";
import { frameClock } from "../platform/frameClock.svelte";
import type { DisplayValue } from "./displayValue";
import { number, localized } from "../i18n";
import type { Extremes } from "../series/columns";
import { sinceSet, type Pulses } from "../series/pulses";
import { widestText } from "./textWidth";
import { valueText, wordsOf } from "./valueText";
import type { Channel, Level } from "../api/types";

export interface LimitState {
  level: Level;
  side: "low" | "high";
}

export type Side = "low" | "high";

/** Seconds outside of the reference: idle is never quite even. */
const STEADY = 2;
/** °C from which the references of a warm engine hold for the others; below them the coolant itself is too cold. */
const WARM = 70;

/** On which side of its reference a value is; null unless the engine idles and is warm. */
export function sideOf(
  value: number | undefined,
  channel: Pick<Channel, "reference"> | undefined,
  engine: { idle: number | undefined; coolant: number | undefined },
): Side | null {
  const reference = channel?.reference;
  if (value === undefined || !reference || !engine.idle || !((engine.coolant ?? -Infinity) >= WARM)) return null;
  return value < reference[0] ? "low" : value > reference[1] ? "high" : null;
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
  /** The level of a flag that means trouble: that of its alarm, or the colour that the catalog gives it without one. */
  private readonly troubled = $derived.by<Level | null>(() => {
    if (!this.channel?.flag) return null;
    const { alarm_when_true: alarm, lamp } = this.channel;
    const level = alarm === "none" ? lamp?.trouble : alarm;
    return level && level !== "none" ? level : null;
  });
  /** Seconds since such a flag was set, while it is still shown: it may be set too shortly to be seen. Null: it is not held. */
  readonly held = $derived.by<number | null>(() => {
    if (this.troubled === null || this.kind === "none" || this.value) return null;
    const { source } = this.stores.display;
    return frameClock.eachFrame(() => sinceSet(source.columns, this.name(), source.now()));
  });
  /** How often a flag was set, over the time of the extremes; null for another channel. */
  readonly pulses = $derived.by<Pulses | null>(() => {
    if (!this.channel?.flag) return null;
    return frameClock.slowly(() => this.stores.display.source.pulses(this.name()));
  });
  /** The value as it is read: a word for a flag, else the number. */
  readonly shown = $derived(valueText(this.channel, this.held === null ? this.value : 1));
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
    return limitState(this.held === null ? this.value : 1, this.channel);
  });
  /** The values of a sound warm engine at idle. */
  readonly reference = $derived(this.channel?.reference ? [...new Set(this.channel.reference)].map((end) => number(end)).join("–") : "");
  /** On which side of the reference the value has been for a while, in an engine that idles warm; null: inside, or no such engine. */
  readonly off = $derived.by(() => frameClock.slowly(() => this.steadySide()));
  readonly level = $derived(this.limitState?.level ?? null);
  /** The level of a flag that is on, or held, and means trouble. */
  readonly trouble = $derived(this.value || this.held !== null ? this.troubled : null);

  private side: Side | null = null;
  private since = 0;

  constructor(private readonly name: () => string) {}

  private steadySide(): Side | null {
    const { absent, display } = this.stores;
    if (absent.has(this.name())) return null; // its value means nothing
    const latest = (name: string) => {
      const shown = display.value(name);
      return shown.kind === "none" ? undefined : shown.value;
    };
    const now = display.source.now();
    const side = sideOf(latest(this.name()), this.channel, { idle: latest("RXX"), coolant: latest("TWAT") });
    if (side !== this.side || now < this.since) [this.side, this.since] = [side, now];
    return side !== null && now - this.since >= STEADY ? side : null;
  }
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
