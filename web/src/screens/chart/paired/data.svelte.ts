// The rows that Scatter and Table use: of the displayed source, or of the second recording, with what cannot be used and why.
import type { LineEvent } from "../../../lib/api/types";
import type { Columns } from "../../../lib/series/columns";
import type { RecordingData } from "../../../lib/recording/recordingData.svelte";
import type { Stores } from "../../../stores";
import { percent } from "../../../lib/i18n";
import { t } from "./messages";

export interface Data {
  columns: Columns;
  events: readonly LineEvent[];
  span: readonly [number, number] | null;
  /** Rows still come. */
  grows: boolean;
  /** The rows cannot be counted: still loading (with its share), or too many to be loaded completely. */
  problem: { kind: "loading"; share: number } | { kind: "coarse" } | { kind: "failed"; text: string } | null;
}

/** The displayed source: the selection between the cursors, or all. */
export function ownData({ cursors, display, live, player }: Stores): Data {
  const { source } = display;
  const selected = cursors.between;
  if (source.kind === "recording") return { ...recorded(player), span: selected };
  // Values of before the page was opened are decimated: they can't be counted.
  const since = live.decimatedUntil + 1e-6;
  const until = source.paused ? source.now() : Infinity;
  const span: [number, number] = selected ? [Math.max(since, selected[0]), Math.min(until, selected[1])] : [since, until];
  return { columns: source.columns, events: source.events, span, grows: !source.paused, problem: null };
}

/** All of the second recording; null: there is none. */
export const secondData = ({ comparison }: Stores): Data | null => (comparison.detail ? recorded(comparison) : null);

/** Why the second recording is not among what is shown; empty: it is, or there is none. */
export function lackOf(second: Data | null): string {
  const problem = second?.problem;
  if (!problem) return "";
  if (problem.kind === "failed") return problem.text;
  return problem.kind === "coarse" ? t("coarseSecond") : t("loadingSecond", { percent: percent(problem.share) });
}

function recorded(data: RecordingData): Data {
  const { columns, events } = data;
  let problem: Data["problem"] = null;
  if (data.error) problem = { kind: "failed", text: data.error.advice };
  else if (data.coarse) problem = { kind: "coarse" };
  else if (data.loaded < 1) problem = { kind: "loading", share: data.loaded };
  return { columns, events, span: null, grows: false, problem };
}

/** When gaps begin, ascending. */
export const gapsOf = (events: readonly LineEvent[]): number[] =>
  events.flatMap((event) => (event.kind === "gap" ? [event.began] : [])).sort((one, other) => one - other);
