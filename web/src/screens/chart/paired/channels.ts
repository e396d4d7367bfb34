// Names and values of channels as Scatter and Table show them.
import { catalog } from "../../../lib/api/catalog.svelte";
import { valueText } from "../../../lib/channels/valueText";
import { localized } from "../../../lib/i18n";

/** Short name. */
export const nameOf = (name: string): string => localized(catalog.get(name)?.short) || name;

/** Short name with the unit. */
export function titleOf(name: string): string {
  const unit = localized(catalog.get(name)?.unit);
  return unit ? `${nameOf(name)}, ${unit}` : nameOf(name);
}

/** A measured value. */
export function measured(name: string, value: number): string {
  const channel = catalog.get(name);
  return valueText(channel, Number.isFinite(value) ? value : null, channel?.decimals ?? 2);
}
