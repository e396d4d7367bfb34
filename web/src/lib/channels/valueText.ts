// A value as it is read: a number, or one of the two words of a flag.
import { dictionary, localized, number, unitAfter } from "../i18n";
import type { Channel } from "../api/types";

const t = dictionary({ on: { en: "on", ru: "вкл." }, off: { en: "off", ru: "выкл." } });

/** The words of a flag, off and on; none for a number. */
export function wordsOf(channel: Channel | undefined): string[] {
  if (!channel?.flag) return [];
  return channel.lamp ? [localized(channel.lamp.off), localized(channel.lamp.on)] : [t("off"), t("on")];
}

/** A value without its unit; a dash for null. */
export function valueText(channel: Channel | undefined, value: number | null, decimals = channel?.decimals ?? 0): string {
  if (value === null || !channel?.flag) return number(value, decimals);
  return wordsOf(channel)[value ? 1 : 0]!;
}

/** The same with its unit; a flag and a dash have none. */
export function valueWithUnit(channel: Channel | undefined, value: number | null): string {
  const unit = value === null || channel?.flag ? "" : unitAfter(value, channel?.unit, channel?.decimals);
  return `${valueText(channel, value)} ${unit}`.trim();
}
