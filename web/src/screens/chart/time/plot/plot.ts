// One pane as a uPlot: series and axes from its traces, gaps hatched behind the lines. Each line has a scale of its own, whose range is
// computed when it is drawn (`paneAxes`). Cursor, wheel and gestures are implemented by the chart, not by uPlot.
import uPlot from "uplot";
import { localized, number } from "../../../../lib/i18n";
import type { CatalogStore } from "../../../../lib/api/catalog.svelte";
import { axisKey, type Axis } from "../../../../lib/series/valueAxis";
import { counted, timesOfDay } from "./timeAxis";
import { wrapText, type GapBand } from "../data/flags";
import { stretched } from "./scales";
import type { Stretch, Trace } from "../view.svelte";

export const LEFT = 58;
export const RIGHT = 14;
const BOTTOM = 30;
/** Dashes of the second recording, in CSS pixels. */
const DASH = [5, 4];
/** How opaque a stripe and its edge are. */
const STRIPE = 0.13;
const STRIPE_EDGE = 0.5;

export interface Look {
  text: string;
  muted: string;
  grid: string;
  hatch: string;
  ground: string;
  traces: string[];
  font: string;
}

export interface PlotPlan {
  traces: Trace[];
  catalog: Pick<CatalogStore, "get">;
  stacked: boolean;
  /** The lowest pane has the time axis. */
  foot: boolean;
  /** Some pane has a second axis: all reserve room for it, so that times are aligned. */
  second: boolean;
  /** In a comparison each trace is drawn a second time, dashed, and time is counted from here. Null: no comparison, times of day. */
  zero: number | null;
  look: Look;
  stretch: () => Stretch | undefined;
  /** The axis of that series (from 0), computed before each drawing; undefined: not drawn yet. */
  axisOf: (series: number) => Axis | undefined;
  gaps: () => GapBand[];
  /** Gaps of that series (from 0) as [from, to]. */
  gapsOf: (series: number) => readonly [number, number][];
  /** A range of that channel, drawn behind its line. */
  bandOf: (name: string) => readonly [number, number] | undefined;
}

/** At most two axes are drawn, in the order of the traces: the first line of each, and whether it has no other. Flags have no axis. */
export function axesDrawn(traces: readonly Trace[], catalog: PlotPlan["catalog"], stacked: boolean): { line: number; alone: boolean }[] {
  if (stacked) return [];
  const keys = traces.map(({ name, hidden }) => {
    const channel = catalog.get(name);
    return hidden || channel?.flag ? null : axisKey(name, channel);
  });
  const drawn = [...new Set(keys)].filter((key) => key !== null).slice(0, 2);
  return drawn.map((key) => ({ line: keys.indexOf(key), alone: keys.indexOf(key) === keys.lastIndexOf(key) }));
}

const scaleOf = (series: number) => `line ${series}`;

export function makePlot(plan: PlotPlan, width: number, height: number, target: HTMLElement): uPlot {
  const visible = plan.traces.filter(({ hidden }) => !hidden);
  const { look, zero } = plan;
  const lines = zero === null ? visible.length : 2 * visible.length;
  const scales: uPlot.Scales = { x: { time: zero === null, auto: false } };
  for (let series = 0; series < lines; series += 1) {
    scales[scaleOf(series)] = {
      range: () => {
        const { low, high } = plan.axisOf(series) ?? { low: 0, high: 1 };
        return stretched([low, high], plan.stretch());
      },
    };
  }
  const drawn = axesDrawn(visible, plan.catalog, plan.stacked);
  const axis = { font: look.font, grid: { stroke: look.grid, width: 1 }, ticks: { stroke: look.grid, width: 1, size: 4 } };
  const times =
    zero === null
      ? { values: (_: uPlot, splits: number[], __: number, ___: number, step: number) => timesOfDay(splits, step) }
      : counted(zero);
  const axes: uPlot.Axis[] = [
    {
      ...axis,
      ...times,
      // No labels: an empty label is drawn as well and costs as much as a short one.
      ...(plan.foot ? {} : { values: () => [] }),
      stroke: look.muted,
      size: plan.foot ? BOTTOM : 0,
      space: 90,
      ticks: { ...axis.ticks, show: plan.foot },
    },
    ...drawn.map(({ line: series, alone }, index) => {
      // Below 0 there may be room, but there are no values: nothing is labelled there.
      const filter = (_: uPlot, splits: number[]) => splits.map((value) => (plan.axisOf(series)?.floor && value < 0 ? null : value));
      return {
        ...axis,
        scale: scaleOf(series),
        side: index === 0 ? 3 : 1,
        size: LEFT,
        space: 34,
        stroke: alone ? look.traces[visible[series]!.colour - 1]! : look.muted,
        filter,
        ticks: { ...axis.ticks, filter },
        grid: index === 0 ? { ...axis.grid, filter } : { show: false },
        values: (_: uPlot, splits: (number | null)[]) => splits.map((value) => (value === null ? null : number(value))),
      };
    }),
  ];
  const left = drawn.length > 0 ? 0 : LEFT;
  const right = plan.second ? (drawn.length > 1 ? 0 : LEFT) : RIGHT;
  const line = (trace: Trace, index: number, second: boolean): uPlot.Series => {
    return {
      label: trace.name,
      scale: scaleOf(index + (second ? visible.length : 0)),
      stroke: look.traces[trace.colour - 1]!,
      width: second ? 1.25 : 1.75,
      ...(second ? { dash: DASH.map((length) => length * devicePixelRatio) } : {}),
      points: { show: false },
      paths: plan.catalog.get(trace.name)?.flag ? uPlot.paths.stepped!({ align: 1 }) : uPlot.paths.linear!(),
      gaps: (plot) => interruptions(plot, plan, index + (second ? visible.length : 0), second),
    };
  };
  const second = zero === null ? [] : visible.map((trace, index) => line(trace, index, true));
  return new uPlot(
    {
      width,
      height,
      padding: [6, right, plan.foot ? 0 : 4, left],
      legend: { show: false },
      cursor: { show: false },
      scales,
      axes,
      series: [{}, ...visible.map((trace, index) => line(trace, index, false)), ...second],
      hooks: { drawAxes: [(plot) => stripes(plot, visible, plan), (plot) => hatch(plot, plan)] },
    },
    [[], ...visible.map(() => []), ...second.map(() => [])],
    target,
  );
}

/** Interruptions of a line in canvas pixels: gaps of the connection, and times in which this channel has no value. */
function interruptions(plot: uPlot, plan: PlotPlan, series: number, second: boolean): uPlot.Series.Gaps {
  const place = (time: number) => Math.round(plot.valToPos(time, "x", true));
  const between = plan
    .gaps()
    .filter((gap) => gap.second === second && gap.to > gap.from)
    .map(({ from, to }): [number, number] => [from, to]);
  return [...plan.gapsOf(series), ...between]
    .sort((one, other) => one[0] - other[0])
    .map(([from, to]): [number, number] => [place(from), place(to)])
    .filter(([from, to]) => to > from);
}

/** The reference's ranges, in the colours of their lines; an edge of its own, so that a single value is seen too. */
function stripes(plot: uPlot, visible: readonly Trace[], { bandOf, catalog, look }: PlotPlan): void {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  visible.forEach(({ name, colour }, series) => {
    const band = catalog.get(name)?.flag ? undefined : bandOf(name);
    if (!band) return;
    const place = (value: number) => Math.round(plot.valToPos(value, scaleOf(series), true));
    const [bottom, top] = [place(band[0]), place(band[1])];
    ctx.fillStyle = look.traces[colour - 1]!;
    ctx.globalAlpha = STRIPE;
    ctx.fillRect(bbox.left, top, bbox.width, bottom - top);
    ctx.globalAlpha = STRIPE_EDGE;
    for (const edge of [top, bottom]) ctx.fillRect(bbox.left, edge, bbox.width, devicePixelRatio);
  });
  ctx.restore();
}

function hatch(plot: uPlot, plan: PlotPlan): void {
  const { ctx, bbox } = plot;
  const gaps = plan.gaps();
  if (gaps.length === 0) return;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  const step = 9 * devicePixelRatio;
  for (const gap of gaps) {
    const from = Math.max(bbox.left, plot.valToPos(gap.from, "x", true));
    const to = Math.min(bbox.left + bbox.width, plot.valToPos(gap.to, "x", true));
    const wide = Math.max(to - from, devicePixelRatio);
    ctx.save();
    ctx.beginPath();
    ctx.rect(from, bbox.top, wide, bbox.height);
    ctx.clip();
    ctx.strokeStyle = plan.look.hatch;
    ctx.lineWidth = devicePixelRatio;
    ctx.beginPath();
    // The grid starts at the gap's edge and moves with it; the second recording's lines lean the other way.
    const [near, far] = gap.second ? [bbox.top, bbox.top + bbox.height] : [bbox.top + bbox.height, bbox.top];
    for (let x = from - bbox.height; x < from + wide; x += step) {
      ctx.moveTo(x, near);
      ctx.lineTo(x + bbox.height, far);
    }
    ctx.stroke();
    if (plan.foot && wide > 60 * devicePixelRatio) {
      ctx.font = `${13 * devicePixelRatio}px ${plan.look.font.replace(/^\S+ /, "")}`;
      write(ctx, localized(gap.reason), from, wide, gap.second ? bbox.top : bbox.top + bbox.height, gap.second, plan.look);
    }
    ctx.restore();
  }
  ctx.restore();
}

/**
 * Write text into a band, in at most three lines, on a background so that the hatching does not cross it: at the foot, the second
 * recording's at the top.
 */
function write(ctx: CanvasRenderingContext2D, words: string, left: number, wide: number, edge: number, atTop: boolean, look: Look): void {
  const pad = 6 * devicePixelRatio;
  const line = 16 * devicePixelRatio;
  const lines = wrapText(words, (text) => ctx.measureText(text).width <= wide - 2 * pad, 3);
  ctx.textBaseline = "top";
  ctx.textAlign = "left";
  lines.forEach((text, index) => {
    const top = atTop ? edge + pad + line * index : edge - pad - line * (lines.length - index);
    ctx.fillStyle = look.ground;
    ctx.fillRect(left + pad / 2, top - 2, ctx.measureText(text).width + pad, line);
    ctx.fillStyle = look.text;
    ctx.fillText(text, left + pad, top);
  });
}
