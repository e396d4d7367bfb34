// Scales of a strip's lines: one for each unit. They change seldom, and noise in the last digit does not fill them.
import type { Channel } from "../../../lib/api/types";
import { steadyScale } from "../../../lib/series/rollingTraces";
import type { Range } from "./gaugeScale";

interface Group {
  min: number;
  max: number;
  least: number;
  names: string[];
}

/** The scale of each line with values; `before`: the last answer. */
export function scalesOf(
  names: readonly string[],
  before: ReadonlyMap<string, Range>,
  channelOf: (name: string) => Channel | undefined,
  seenOf: (name: string) => { min: number; max: number } | undefined,
): Map<string, Range> {
  const groups = new Map<string, Group>();
  for (const name of names) {
    const seen = seenOf(name);
    if (!seen) continue;
    const channel = channelOf(name);
    const unit = channel?.unit.en || `own ${name}`;
    const group = groups.get(unit) ?? { ...seen, least: 0, names: [] };
    group.min = Math.min(group.min, seen.min);
    group.max = Math.max(group.max, seen.max);
    group.least = Math.max(group.least, channel?.span_least ?? 1);
    group.names.push(name);
    groups.set(unit, group);
  }
  const scales = new Map<string, Range>();
  for (const group of groups.values()) {
    const scale = steadyScale(before.get(group.names[0]!), group, group.least);
    for (const name of group.names) scales.set(name, scale);
  }
  return scales;
}
