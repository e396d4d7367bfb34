// Collects what the time chart shows as a `Picture`, in the colours of the day theme.
import { carName } from "../../../../lib/car/carText";
import { localized, moment as dateAndTime, number, timeOfDay } from "../../../../lib/i18n";
import { theme } from "../../../../lib/platform/theme.svelte";
import type { Stores } from "../../../../stores";
import { flagsOf } from "../data/flags";
import { legendRow } from "../panes/legendRow";
import { drawnPane } from "../plot/drawing";
import { axesDrawn } from "../plot/plot";
import { stretched } from "../plot/scales";
import { axisTimes, elapsed, timesOfDay } from "../plot/timeAxis";
import { type Pane } from "../view.svelte";
import type { Picture, PictureLine, PicturePane } from "./chartSvg";
import { piecesOf } from "./pieces";
import { t } from "../messages";

/** Points across a pane: twice its pixels, so that it prints sharply. */
const POINTS = 1900;
const PANE_HEIGHT = 150;
const MUTED = "#434d55";

export function pictureOf(stores: Stores): Picture {
  const { chartData, comparison, cursors, display, player, view } = stores;
  const [from, to] = view.window();
  const colours = theme.dayTokens(Array.from({ length: 8 }, (_, index) => `trace-${index + 1}`).concat("warning", "danger", "text"));
  const zero = comparison.active ? player.first : null;
  const label = (time: number) => (zero === null ? timesOfDay([time], 0.1)[0]! : elapsed(time - zero, 0.1));
  const marks: [number | null, boolean][] = [
    [cursors.a, false],
    [cursors.b, true],
  ];
  return {
    ...titlesOf(stores, from, to),
    from,
    to,
    panes: view.panes.map((pane) => paneOf(stores, pane, from, to, colours)),
    gaps: chartData.gapsIn(from, to).map((gap) => ({ from: gap.from, to: gap.to, reason: localized(gap.reason) })),
    flags: flagsOf(display.source.events, from, to, 0).map((flag) => ({
      time: flag.time,
      text: (flag.kind === "marker" ? "⚑ " : "▲ ") + (typeof flag.label === "string" ? flag.label : localized(flag.label)),
      colour: colours[flag.kind === "warning" || flag.kind === "danger" ? flag.kind : "text"]!,
    })),
    cursors: marks.flatMap(([time, dashed]) => (time === null || time < from || time > to ? [] : [{ time, text: label(time), dashed }])),
    times: axisTimes(from, to, zero),
    number: (value) => number(value),
  };
}

/**
 * Of a recording its car with the plate, and its name; of live values that they are (their car is not known here). Then the date. Below, the
 * unit and the times of the window.
 */
function titlesOf({ comparison, live, player, reference }: Stores, from: number, to: number): Pick<Picture, "title" | "subtitle"> {
  const recorded = player.shown;
  const date = recorded ? recorded.date : from;
  const other = recorded && comparison.active && comparison.detail ? `– – ${comparison.detail.id}` : "";
  const title = [recorded ? carName(recorded.car) : "", recorded?.id ?? t("liveValues"), other, date === null ? "" : dateAndTime(date)];
  const model = localized(recorded ? recorded.model : live.state?.model);
  return {
    title: title.filter(Boolean).join(" · "),
    subtitle: [model, `${timeOfDay(from)} – ${timeOfDay(to)}`, reference.title].filter(Boolean).join(" · "),
  };
}

function paneOf(stores: Stores, pane: Pane, from: number, to: number, colours: Record<string, string>): PicturePane {
  const { catalog, chartData, view } = stores;
  const { shown: traces, times, values, lines, holes, ...drawn } = drawnPane(stores, pane.traces, from, to, POINTS, PANE_HEIGHT);
  const axes = drawn.axes.map((axis) => {
    const [low, high] = stretched([axis.low, axis.high], view.stretches[pane.id]);
    return { ...axis, low, high };
  });
  const gaps = chartData.gapsIn(from, to);
  const colourOf = (index: number) => colours[`trace-${traces[index % traces.length]!.colour}`]!;
  return {
    legend: traces.map(({ name }, index) => ({ colour: colourOf(index), name: catalog.nameOf(name), ...legendOf(stores, name) })),
    axes: axesDrawn(traces, catalog, view.stacked).map(({ line, alone }) => ({ ...axes[line]!, colour: alone ? colourOf(line) : MUTED })),
    lines: lines.map(({ channel, band }, index): PictureLine => {
      const dashed = index >= traces.length;
      const broken = [...holes[index]!, ...gaps.filter((gap) => gap.second === dashed).map((gap): [number, number] => [gap.from, gap.to])];
      const { low, high } = axes[index]!;
      return {
        colour: colourOf(index),
        dashed,
        stepped: channel?.flag ?? false,
        band: channel?.flag ? null : (band ?? null),
        low,
        high,
        pieces: piecesOf(times, values[index]!, broken),
      };
    }),
  };
}

/** As in the legend on the screen. */
function legendOf(stores: Stores, name: string): { value: string; more: string } {
  const { value, unit, mean, difference, second } = legendRow(stores, name);
  const more = [
    mean && `${t("mean")} ${mean}`,
    difference && `Δ ${difference}`,
    second && !second.lacking && `– – ${second.value} ${unit}`.trim(),
  ];
  return { value: `${value} ${unit}`.trim(), more: more.filter(Boolean).join(" · ") };
}
