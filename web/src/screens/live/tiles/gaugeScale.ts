// The scale of a gauge and its bands. The arc has 240° and is open at the bottom.
import type { Channel } from "../../../lib/api/types";

export interface Range {
  low: number;
  high: number;
}

/**
 * The range of a gauge. With limits: the plausible range, so that the limits keep their places. Otherwise warm idle and the values seen,
 * with room, so that 15 kg/h of 450 is readable; it grows in steps, not with each value.
 */
export function rangeOf(channel: Channel | undefined, seen?: { min: number; max: number }): Range {
  const plausible = channel?.range && channel.range[1] > channel.range[0] ? channel.range : null;
  const limits = Object.values(channel?.limits ?? {}).filter((limit): limit is number => limit !== null);
  const reference = channel?.reference && channel.reference[1] > channel.reference[0] ? channel.reference : [];
  if (plausible && (limits.length > 0 || reference.length === 0)) return { low: plausible[0], high: plausible[1] };
  const known = [...reference, ...limits, ...(seen ? [seen.min, seen.max] : [])];
  if (known.length === 0) return { low: 0, high: 1 };
  const top = Math.max(...known);
  const bottom = Math.min(0, ...known);
  const room = top - bottom || Math.abs(top) || 1;
  const low = bottom < 0 ? round(bottom - room * 0.2, -1) : 0;
  const high = round(top + room * 0.25, 1);
  if (plausible) return { low: Math.max(low, plausible[0]), high: Math.min(high, plausible[1]) };
  // A percentage does not exceed 100.
  return { low, high: channel?.unit.en === "%" && top <= 100 ? Math.min(high, 100) : high };
}

/** Round away from zero to 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6 or 8 of a decade. */
function round(value: number, way: 1 | -1): number {
  if (value === 0) return 0;
  const decade = 10 ** Math.floor(Math.log10(Math.abs(value)));
  const steps = [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10];
  const share = Math.abs(value) / decade;
  const step = steps.find((candidate) => candidate >= share - 1e-9) ?? 10;
  return Number((way * step * decade).toPrecision(6));
}

export const share = (value: number, range: Range): number =>
  Math.min(1, Math.max(0, (value - range.low) / (range.high - range.low)));

export interface Band {
  from: number;
  to: number;
  level: "danger" | "warning";
}

/** The parts of the arc beyond the limits, as shares. */
export function bandsOf(channel: Channel | undefined, range: Range): Band[] {
  const limits = channel?.limits;
  if (!limits) return [];
  const at = (value: number | null, without: number) => (value === null ? without : share(value, range));
  const dangerLow = at(limits.danger_low, 0);
  const warningLow = at(limits.warning_low, dangerLow);
  const dangerHigh = at(limits.danger_high, 1);
  const warningHigh = at(limits.warning_high, dangerHigh);
  const bands: Band[] = [
    { from: 0, to: dangerLow, level: "danger" },
    { from: dangerLow, to: warningLow, level: "warning" },
    { from: warningHigh, to: dangerHigh, level: "warning" },
    { from: dangerHigh, to: 1, level: "danger" },
  ];
  return bands.filter(({ from, to }) => to > from);
}

const START = 150;
const SWEEP = 240;

const point = (at: number, radius: number, x: number, y: number): string => {
  const angle = ((START + SWEEP * at) * Math.PI) / 180;
  return `${(x + radius * Math.cos(angle)).toFixed(2)} ${(y + radius * Math.sin(angle)).toFixed(2)}`;
};

/** A part of the arc as an SVG path, between two shares. */
export function arc(from: number, to: number, radius: number, x = 100, y = 92): string {
  const large = (to - from) * SWEEP > 180 ? 1 : 0;
  return `M${point(from, radius, x, y)}A${radius} ${radius} 0 ${large} 1 ${point(to, radius, x, y)}`;
}

/** A mark across the arc. */
export const tick = (at: number, inner: number, outer: number, x = 100, y = 92): string =>
  `M${point(at, inner, x, y)}L${point(at, outer, x, y)}`;
