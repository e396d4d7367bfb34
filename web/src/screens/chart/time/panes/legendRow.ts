// What the legend says of a trace, on the screen and in a picture: its value at the cursor; with two cursors the difference and the mean between
// them; in a comparison the second recording's value and the difference. A difference is what is shown minus the other: the first cursor minus
// the second one, this recording minus the second one.
import { valueText } from "../../../../lib/channels/valueText";
import { localized, number, signed } from "../../../../lib/i18n";
import { isForeign } from "../../../../lib/recording/foreign";
import type { Stores } from "../../../../stores";
import { meanOf } from "../data/value";

export interface LegendRow {
  /** A column of another program's log: only the second recording has it. */
  foreign: boolean;
  title: string;
  short: string;
  unit: string;
  value: string;
  /** Live, and not in the current plan. */
  notSampled: boolean;
  stale: boolean;
  difference: string;
  mean: string;
  /** Of the second recording; null: no comparison. */
  second: { value: string; more: string; lacking: boolean } | null;
}

export function legendRow(stores: Stores, name: string): LegendRow {
  const { catalog, chartData, comparison, cursors, display, live } = stores;
  const channel = catalog.get(name);
  const now = display.value(name);
  const value = cursors.a !== null ? chartData.valueOf(name, cursors.a) : now.kind === "none" ? null : now.value;
  // While aligning the second cursor marks the moment on the dashed line.
  const aligning = comparison.aligning !== null;
  const other = cursors.b === null || aligning ? null : chartData.valueOf(name, cursors.b);
  const between = aligning ? null : cursors.between;
  const decimals = channel?.decimals ?? 0;
  const minus = (one: number | null, two: number | null) =>
    one === null || two === null || channel?.flag ? "" : signed(one - two, decimals);
  return {
    foreign: isForeign(name),
    title: channel ? localized(channel.text) : name,
    short: channel ? localized(channel.short) : name,
    unit: channel?.flag ? "" : localized(channel?.unit),
    value: valueText(channel, value),
    notSampled: value === null && display.source.kind === "live" && isNotSampled(),
    stale: cursors.a === null && now.kind === "stale",
    difference: minus(value, other),
    mean: between && !channel?.flag ? number(meanOf(display.source.columns, name, ...between), decimals + 1) : "",
    second: comparison.active ? secondOf() : null,
  };

  function isNotSampled(): boolean {
    const { state } = live;
    return state?.line === "sampling" && !state.plan.wanted.some((wanted) => wanted.name === name);
  }

  function secondOf(): LegendRow["second"] {
    const time = chartData.moment;
    const other = time === null ? null : chartData.secondValueOf(name, time);
    return { value: valueText(channel, other), more: minus(value, other), lacking: comparison.extremes(name) === undefined };
  }
}
