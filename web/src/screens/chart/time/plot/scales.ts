// The value range that one line is drawn with: its axis, placed in a lane when stacked, and moved by gestures.
import { axesOf, type Axis, type Line } from "../../../../lib/series/valueAxis";
import type { Stretch } from "../view.svelte";

type Range = [number, number];

/** Apply the moves made by wheel and drag. */
export function stretched([low, high]: Range, stretch: Stretch | undefined): Range {
  if (!stretch) return [low, high];
  const extent = (high - low) * stretch.scale;
  const middle = (low + high) / 2 + (high - low) * stretch.shift;
  return [middle - extent / 2, middle + extent / 2];
}

/** The range that places [low, high] in lane `index` of `count`, the first one at the top. */
export function lane([low, high]: Range, index: number, count: number): Range {
  const extent = (high - low) * count;
  const bottom = low - (high - low) * (count - 1 - index);
  return [bottom, bottom + extent];
}

/** A flag's lane when stacked. */
const FLAG: Axis = { low: -0.15, high: 1.15, floor: true };

/**
 * The axes of the lines of a pane: of its own traces, then of the second recording's, in the same order. Stacked, each trace has a lane of
 * its own, with no axis beside it.
 */
export function paneAxes(lines: readonly Line[], traces: number, stacked: boolean, height: number): Axis[] {
  if (!stacked) return axesOf(lines, height);
  const axes = new Array<Axis>(lines.length);
  for (let trace = 0; trace < traces; trace += 1) {
    const places = lines.length > traces ? [trace, trace + traces] : [trace];
    const own = axesOf(
      places.map((place) => lines[place]!),
      height / traces,
    );
    places.forEach((place, index) => {
      const axis = lines[place]!.channel?.flag ? FLAG : own[index]!;
      const [low, high] = lane([axis.low, axis.high], trace, traces);
      axes[place] = { ...axis, low, high };
    });
  }
  return axes;
}
