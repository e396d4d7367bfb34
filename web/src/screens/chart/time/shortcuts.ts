// Keyboard shortcuts of the chart: moving the cursor, zoom, fit.
import { comparison } from "../../../lib/recording/comparison.svelte";
import { cursors } from "../../../lib/display/cursors.svelte";
import type { Binding } from "../../../lib/frame/shortcuts.svelte";
import { markersOf, nextMark } from "../../../lib/control/markers.svelte";
import { player } from "../../../lib/recording/player.svelte";
import { display } from "../../../lib/display/source.svelte";
import { nextGap } from "./data/flags";
import { everyGap, moment } from "./data/sources";
import { find } from "./find/find.svelte";
import { t as findText } from "./find/messages";
import { view } from "./view.svelte";
import { t } from "./messages";

export function fit(): void {
  view.fit();
  view.showAll();
}

/** Move the cursor, and in a recording the player; while aligning, use the moment for the comparison. */
export function choose(time: number): void {
  cursors.a = time;
  if (!comparison.aligning) {
    if (display.source.kind === "recording") player.seek(time);
    return;
  }
  comparison.alignAt(time);
  // The moment on the dashed line stays marked until the alignment is done.
  cursors.b = comparison.aligning ? time : null;
}

const middle = () => cursors.a ?? (view.window()[0] + view.window()[1]) / 2;

function step(samples: number): void {
  const { columns } = display.source;
  const row = Math.min(columns.length - 1, Math.max(0, columns.rowAt(middle()) + samples));
  if (columns.length > 0) cursors.a = columns.times()[row]!;
}

function toGap(step: 1 | -1): void {
  const gap = nextGap(everyGap(), moment(cursors.a) ?? view.window()[0], step);
  if (!gap) return;
  const within = (gap.from + gap.to) / 2;
  view.bring(within);
  cursors.a = within;
}

/** Go to a moment: the window, the cursor and the player. */
export function goTo(time: number): void {
  view.bring(time);
  choose(time);
}

export function toMarker(step: 1 | -1): void {
  const mark = nextMark(markersOf(display.source.events), moment(cursors.a) ?? view.window()[step > 0 ? 0 : 1], step);
  if (mark) goTo(mark.time);
}

function escape(): void {
  if (comparison.aligning) comparison.toggleAligning();
  else cursors.a = null;
  cursors.b = null;
}

const arrow = (code: "ArrowLeft" | "ArrowRight", shift: boolean, samples: number): Binding => ({
  code,
  shift,
  show: `${shift ? "⇧" : ""}${samples < 0 ? "←" : "→"}`,
  text: () => t(samples < 0 ? "left" : "right"),
  run: () => step(samples),
});

export const bindings: Binding[] = [
  { code: "KeyS", show: "S", text: () => t("stackLong"), run: () => (view.stacked = !view.stacked) },
  { code: "KeyC", show: "C", text: () => t("second"), run: () => view.toggleSecond() },
  { code: "KeyG", show: "G", text: () => t("nextGap"), run: () => toGap(1) },
  { code: "KeyG", shift: true, show: "⇧G", text: () => t("nextGap"), run: () => toGap(-1) },
  { code: "KeyN", show: "N", text: () => t("nextMarker"), run: () => toMarker(1) },
  { code: "KeyN", shift: true, show: "⇧N", text: () => t("previousMarker"), run: () => toMarker(-1) },
  { code: "NumpadDivide", key: "/", show: "/", text: () => findText("findLong"), run: () => (find.open = true) },
  { code: "Digit0", show: "0", text: () => t("fit"), run: fit },
  { code: "Equal", show: "+", text: () => t("closer"), run: () => view.zoom(0.7, middle()) },
  { code: "Minus", show: "−", text: () => t("farther"), run: () => view.zoom(1 / 0.7, middle()) },
  { code: "Escape", show: "Esc", text: () => t("noCursors"), run: escape },
  arrow("ArrowLeft", false, -1),
  arrow("ArrowRight", false, 1),
  arrow("ArrowLeft", true, -10),
  arrow("ArrowRight", true, 10),
];

/** For live data only: in a recording L is the loop. */
export const newest: Binding = { code: "KeyL", show: "L", text: () => t("followLong"), run: () => view.follow() };

/** Selects the moment at the cursor while aligning. */
export const chosen: Binding = {
  code: "Enter",
  show: "Enter",
  text: () => t("chosen"),
  run: () => cursors.a !== null && choose(cursors.a),
};
