// The value axes of the lines in one pane or strip: one for each unit, fitted to what is visible. An axis is never narrower than the
// catalog's least span, so that noise does not fill it, and does not go below 0 for a channel that can't. Constant lines never cover
// each other: the axes have their middles at different heights.
import type { Channel } from "../api/types";
import type { Extremes } from "./columns";
import type { Decimated } from "./decimate";

export interface Axis {
  /** The values at the lower and the upper edge. */
  low: number;
  high: number;
  /** Values below 0 do not exist: the room below 0 has no labels. */
  floor: boolean;
}

export interface Line {
  name: string;
  channel: Channel | undefined;
  /** Its extremes in the window; null: no value there. */
  seen: Extremes | null;
  /** Its drawn points, if lines of one time line are compared. */
  cells?: Decimated["values"][number];
  /** A range that is shown behind it: the axis contains it. */
  band?: readonly [number, number] | undefined;
}

/** Room above and below the values, as a share of their extent. */
const ROOM = 0.06;
/** The height of 0 on the first axis that begins there, and how much higher on each further one; shares of the pane. */
const FOOT = 0.03;
const HIGHER = 0.05;
/** A line that moves less than this share of its axis counts as constant. */
const STILL = 0.02;
/** Pixels between two lines of one axis that would cover each other. */
const BESIDE = 3;
/** The height of a flag's own strip at the foot of the pane. */
const FLAG = 0.24;

/** Lines with the same unit share an axis; a flag has its own, and so has a line without a unit. */
export function axisKey(name: string, channel: Channel | undefined): string {
  return channel?.flag || !channel?.unit.en ? `own ${name}` : channel.unit.en;
}

export const leastSpan = (channel: Channel | undefined): number => channel?.span_least ?? 10 * 10 ** -(channel?.decimals ?? 0);

/** Whether the channel has no negative values; unknown counts as yes, until one is seen. */
export function neverNegative(channel: Channel | undefined): boolean {
  const lowest = channel?.range?.[0] ?? channel?.gauge?.[0];
  return lowest === undefined || lowest >= 0;
}

interface Wanted extends Extremes {
  least: number;
  floor: boolean;
}

/** The axis of a channel that is drawn alone. */
export function axisAlone(channel: Channel | undefined, { min, max }: Extremes): Pick<Axis, "low" | "high"> {
  if (channel?.flag) return { low: -0.2, high: 1.2 };
  return fitted({ min, max, least: leastSpan(channel), floor: neverNegative(channel) });
}

/** The axis number `rank` of `count` in its pane, in whose middle a constant line would be at another height than on the others. */
export function fitted({ min, max, least, floor }: Wanted, rank = 0, count = 1): Axis {
  // However large the values are, both edges differ.
  const finest = 16 * Number.EPSILON * Math.max(Math.abs(min), Math.abs(max));
  const extent = Math.max((max - min) * (1 + 2 * ROOM), least, finest) || 1;
  const below = (extent - (max - min)) * ((count - rank) / (count + 1));
  const stands = floor && min >= 0;
  const low = stands ? Math.max(min - below, -extent * (FOOT + HIGHER * rank)) : min - below;
  return { low, high: low + extent, floor: stands };
}

/** The axis of each line, in the order of the lines. `height`: of the pane, in pixels. */
export function axesOf(lines: readonly Line[], height: number): Axis[] {
  const flags = lines.filter(({ channel }) => channel?.flag);
  const axes = new Map<string, Axis>(flags.map(({ name }, index) => [axisKey(name, flags[index]!.channel), flagAxis(index, flags.length)]));
  const taken: number[] = flags.flatMap(({ name, channel, seen }) =>
    heightsOf([{ name, channel, seen }], axes.get(axisKey(name, channel))!),
  );
  const keys = [...new Set(lines.filter(({ channel }) => !channel?.flag).map(({ name, channel }) => axisKey(name, channel)))];
  keys.forEach((key, rank) => {
    const own = lines.filter(({ name, channel }) => axisKey(name, channel) === key);
    const axis = apart(own, fitted(wantedBy(own), rank, keys.length), taken, lines.length);
    taken.push(...heightsOf(own, axis));
    axes.set(key, axis);
  });
  return lines.map((line, index) => {
    const axis = axes.get(axisKey(line.name, line.channel))!;
    const covered = lines
      .slice(0, index)
      .filter((other) => axisKey(other.name, other.channel) === axisKey(line.name, line.channel) && cover(line, other)).length;
    return covered === 0 ? axis : moved(axis, (covered * BESIDE) / Math.max(1, height));
  });
}

function wantedBy(lines: readonly Line[]): Wanted {
  const seen = lines.flatMap(({ seen, band }) => [...(seen ? [seen] : []), ...(band ? [{ min: band[0], max: band[1] }] : [])]);
  const some = seen.length > 0;
  return {
    min: some ? Math.min(...seen.map(({ min }) => min)) : 0,
    max: some ? Math.max(...seen.map(({ max }) => max)) : 0,
    least: Math.max(...lines.map(({ channel }) => leastSpan(channel))),
    floor: lines.every(({ channel }) => neverNegative(channel)),
  };
}

/** Flags stand over each other at the foot of the pane, each in a strip of its own. */
function flagAxis(index: number, count: number): Axis {
  const strip = Math.min(FLAG, 0.9 / count);
  const extent = 1 / (0.8 * strip);
  const low = -(FOOT + index * strip) * extent;
  return { low, high: low + extent, floor: true };
}

const heightOn = (axis: Axis, value: number): number => (value - axis.low) / (axis.high - axis.low);

/** The same axis with every value `share` of the pane higher. */
const moved = (axis: Axis, share: number): Axis => {
  const by = share * (axis.high - axis.low);
  return { ...axis, low: axis.low - by, high: axis.high - by };
};

/** The heights of the constant lines. */
function heightsOf(lines: readonly Line[], axis: Axis): number[] {
  return lines.flatMap(({ seen }) =>
    seen && seen.max - seen.min <= STILL * (axis.high - axis.low) ? [heightOn(axis, (seen.min + seen.max) / 2)] : [],
  );
}

/** Move the axis until none of its constant lines is at a height that is taken; if there is no room to move, make it longer. */
function apart(lines: readonly Line[], axis: Axis, taken: readonly number[], count: number): Axis {
  const distance = Math.min(0.05, 0.4 / count);
  const { min, max } = wantedBy(lines);
  let tried = axis;
  for (let longer = 0; longer < 6; longer += 1) {
    const [bottom, top] = [heightOn(tried, min), heightOn(tried, max)];
    for (let step = 0; step * distance < 1; step += 1) {
      for (const way of step === 0 ? [0] : [step * distance, -step * distance]) {
        if (step > 0 && (bottom + way < FOOT / 2 || top + way > 1 - FOOT / 2)) continue;
        const placed = moved(tried, way);
        if (heightsOf(lines, placed).every((height) => taken.every((other) => Math.abs(height - other) >= distance - 1e-9))) return placed;
      }
    }
    tried = { ...tried, high: tried.low + (tried.high - tried.low) * 1.3 };
  }
  return axis;
}

/** Whether some constant line lies on another one, with these axes. */
export function anyCovered(lines: readonly Line[], axes: readonly Axis[], height: number): boolean {
  const shares = lines.map((line, index) => heightsOf([line], axes[index]!)[0]);
  return lines.some((line, index) =>
    lines.slice(0, index).some((other, before) => {
      if (axisKey(line.name, line.channel) === axisKey(other.name, other.channel))
        return cover(line, other) && axes[index]!.low === axes[before]!.low;
      const [one, two] = [shares[index], shares[before]];
      return one !== undefined && two !== undefined && Math.abs(one - two) * height < BESIDE - 0.5;
    }),
  );
}

/** Whether two lines of one axis would be drawn on each other: the same constant, or the same points. */
function cover(one: Line, other: Line): boolean {
  if (!one.seen || !other.seen) return false;
  if (one.seen.min !== other.seen.min || one.seen.max !== other.seen.max) return false;
  if (one.seen.min === one.seen.max) return true;
  const [cells, others] = [one.cells, other.cells];
  return cells !== undefined && cells.length === others?.length && cells.every((value, row) => value === others[row]);
}
