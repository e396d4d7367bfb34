// The scale of a gauge, which stands still, and its bands. The arc has 240° and is open at the bottom.
import type { Channel } from "../../../../lib/api/types";

export interface Range {
  low: number;
  high: number;
}

/** The range of a gauge: the tile's own scale, else the catalog's `gauge`; null: neither exists. Values seen do not change it. */
export function rangeOf(channel: Pick<Channel, "gauge"> | undefined, scale: readonly [number, number] | null = null): Range | null {
  const gauge = scale && scale[1] > scale[0] ? scale : channel?.gauge;
  return gauge && gauge[1] > gauge[0] ? { low: gauge[0], high: gauge[1] } : null;
}

/** On which side of the scale a value lies that it cannot show. */
export function beyond(value: number, range: Range): "low" | "high" | null {
  if (value < range.low) return "low";
  return value > range.high ? "high" : null;
}

export const share = (value: number, range: Range): number => Math.min(1, Math.max(0, (value - range.low) / (range.high - range.low)));

export interface Band {
  from: number;
  to: number;
  level: "danger" | "warning";
}

/** The parts of the arc beyond the limits, as shares. */
export function bandsOf(channel: Pick<Channel, "limits"> | undefined, range: Range): Band[] {
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

/** The centre, and the angles, of the arc. */
const X = 100;
const Y = 92;
const START = 150;
const SWEEP = 240;

const point = (at: number, radius: number): string => {
  const angle = ((START + SWEEP * at) * Math.PI) / 180;
  return `${(X + radius * Math.cos(angle)).toFixed(2)} ${(Y + radius * Math.sin(angle)).toFixed(2)}`;
};

/** A part of the arc as an SVG path, between two shares. */
export function arc(from: number, to: number, radius: number): string {
  const large = (to - from) * SWEEP > 180 ? 1 : 0;
  return `M${point(from, radius)}A${radius} ${radius} 0 ${large} 1 ${point(to, radius)}`;
}

/** The least share that is seen as a band, not as a dot. */
const LEAST = 0.03;

/** The ends of a band, around its middle at least so wide that it is seen, inside the arc. */
export function visible(from: number, to: number): [number, number] {
  const more = Math.max(0, LEAST - (to - from)) / 2;
  const begin = Math.min(Math.max(0, from - more), 1 - LEAST);
  const inside = (at: number) => Math.min(1, Math.max(0, at));
  return [inside(Math.min(begin, from)), inside(Math.max(to + more, begin + LEAST))];
}

/** The dash pattern that shows only this part of the whole arc, if its `pathLength` is 1. */
export const dash = (from: number, to: number): string => `0 ${from.toFixed(4)} ${(to - from).toFixed(4)} 1`;

/** The transform that turns what stands at the arc's start to this share. */
export const turned = (at: number): string => `rotate(${(SWEEP * at).toFixed(2)} ${X} ${Y})`;

/** A mark across the arc. */
export const tick = (at: number, inner: number, outer: number): string => `M${point(at, inner)}L${point(at, outer)}`;

/** An arrow at an end of the arc that points beyond it. */
export function endArrow(side: "low" | "high"): string {
  // 240° and −60° of direction: where a needle would go on.
  const out = side === "low" ? -0.045 : 1.045;
  const end = side === "low" ? 0.012 : 0.988;
  return `M${point(end, 64)}L${point(out, 80)}L${point(end, 96)}Z`;
}
