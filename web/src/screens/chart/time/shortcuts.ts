// Keyboard shortcuts of the chart: moving the cursor, zoom, fit.
import type { Binding } from "../../../lib/frame/shortcuts.svelte";
import { markersOf, nextMark } from "../../../lib/control/markers.svelte";
import { nextGap } from "./data/flags";
import { t as findText } from "./find/messages";
import type { Cursors } from "../../../lib/display/cursors.svelte";
import type { Display } from "../../../lib/display/source.svelte";
import type { Comparison } from "../../../lib/recording/comparison.svelte";
import type { Player } from "../../../lib/recording/player.svelte";
import type { ChartData } from "./data/sources";
import type { Find } from "./find/find.svelte";
import type { View } from "./view.svelte";
import { t } from "./messages";

export class ChartMoves {
  constructor(
    private readonly display: Display,
    private readonly player: Player,
    private readonly comparison: Comparison,
    private readonly cursors: Cursors,
    private readonly chartData: ChartData,
    private readonly view: View,
    private readonly find: Find,
  ) {}

  fit(): void {
    this.view.fit();
    this.view.showAll();
  }

  /** Move the cursor, and in a recording the player; while aligning, use the moment for the comparison. */
  choose(time: number): void {
    this.cursors.a = time;
    if (!this.comparison.aligning) {
      if (this.display.source.kind === "recording") this.player.seek(time);
      return;
    }
    this.comparison.alignAt(time);
    // The moment on the dashed line stays marked until the alignment is done.
    this.cursors.b = this.comparison.aligning ? time : null;
  }

  private middle(): number {
    return this.cursors.a ?? (this.view.window()[0] + this.view.window()[1]) / 2;
  }

  private step(samples: number): void {
    const { columns } = this.display.source;
    const row = Math.min(columns.length - 1, Math.max(0, columns.rowAt(this.middle()) + samples));
    if (columns.length > 0) this.cursors.a = columns.times()[row]!;
  }

  private toGap(step: 1 | -1): void {
    const gap = nextGap(this.chartData.gapsIn(), this.chartData.moment(this.cursors.a) ?? this.view.window()[0], step);
    if (!gap) return;
    const within = (gap.from + gap.to) / 2;
    this.view.bring(within);
    this.cursors.a = within;
  }

  /** Go to a moment: the window, the cursor and the player. */
  goTo(time: number): void {
    this.view.bring(time);
    this.choose(time);
  }

  toMarker(step: 1 | -1): void {
    const mark = nextMark(
      markersOf(this.display.source.events),
      this.chartData.moment(this.cursors.a) ?? this.view.window()[step > 0 ? 0 : 1],
      step,
    );
    if (mark) this.goTo(mark.time);
  }

  private escape(): void {
    if (this.comparison.aligning) this.comparison.toggleAligning();
    else this.cursors.a = null;
    this.cursors.b = null;
  }

  private readonly arrow = (code: "ArrowLeft" | "ArrowRight", shift: boolean, samples: number): Binding => ({
    code,
    shift,
    show: `${shift ? "⇧" : ""}${samples < 0 ? "←" : "→"}`,
    text: () => t(samples < 0 ? "left" : "right"),
    run: () => this.step(samples),
  });

  readonly bindings = (): Binding[] => [
    { code: "KeyS", show: "S", text: () => t("stackLong"), run: () => (this.view.stacked = !this.view.stacked) },
    { code: "KeyC", show: "C", text: () => t("second"), run: () => this.view.toggleSecond() },
    { code: "KeyG", show: "G", text: () => t("nextGap"), run: () => this.toGap(1) },
    { code: "KeyG", shift: true, show: "⇧G", text: () => t("nextGap"), run: () => this.toGap(-1) },
    { code: "KeyN", show: "N", text: () => t("nextMarker"), run: () => this.toMarker(1) },
    { code: "KeyN", shift: true, show: "⇧N", text: () => t("previousMarker"), run: () => this.toMarker(-1) },
    { code: "NumpadDivide", key: "/", show: "/", text: () => findText("findLong"), run: () => (this.find.open = true) },
    { code: "Digit0", show: "0", text: () => t("fit"), run: () => this.fit() },
    { code: "Equal", show: "+", text: () => t("closer"), run: () => this.view.zoom(0.7, this.middle()) },
    { code: "Minus", show: "−", text: () => t("farther"), run: () => this.view.zoom(1 / 0.7, this.middle()) },
    { code: "Escape", show: "Esc", text: () => t("noCursors"), run: () => this.escape() },
    this.arrow("ArrowLeft", false, -1),
    this.arrow("ArrowRight", false, 1),
    this.arrow("ArrowLeft", true, -10),
    this.arrow("ArrowRight", true, 10),
    ...(this.display.source.kind === "live" ? [this.newest] : []),
    ...(this.comparison.aligning ? [this.chosen] : []),
  ];

  /** For live data only: in a recording L is the loop. */
  private readonly newest: Binding = { code: "KeyL", show: "L", text: () => t("followLong"), run: () => this.view.follow() };

  /** Selects the moment at the cursor while aligning. */
  private readonly chosen: Binding = {
    code: "Enter",
    show: "Enter",
    text: () => t("chosen"),
    run: () => this.cursors.a !== null && this.choose(this.cursors.a),
  };
}
