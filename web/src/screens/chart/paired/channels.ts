// Names and values of channels as Scatter and Table show them.
import { catalog } from "../../../lib/api/catalog.svelte";
import { localized, number } from "../../../lib/i18n";

/** Short name. */
export const nameOf = (name: string): string => localized(catalog.get(name)?.short) || name;

/** Short name with the unit. */
export function titleOf(name: string): string {
  const unit = localized(catalog.get(name)?.unit);
  return unit ? `${nameOf(name)}, ${unit}` : nameOf(name);
}

/** A measured value: a flag has the text of its lamp. */
export function measured(name: string, value: number): string {
  const channel = catalog.get(name);
  if (!channel?.flag || !Number.isFinite(value)) return number(value, channel?.decimals ?? 2);
  const lamp = channel.lamp;
  if (lamp) return localized(value ? lamp.on : lamp.off);
  return number(value);
}
