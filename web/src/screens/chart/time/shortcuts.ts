// Keyboard shortcuts of the chart: moving the cursor, zoom, fit.
import type { Binding } from "../../../lib/frame/shortcuts";
import { markersOf, nextMark } from "../../../lib/control/markers.svelte";
import { nextGap } from "./data/flags";
import { t as findText } from "./find/messages";
import { t } from "./messages";
import type { Stores } from "../../../stores";

export class ChartMoves {
  constructor(private readonly app: Pick<Stores, "display" | "player" | "comparison" | "cursors" | "chartData" | "view" | "find">) {}

  fit(): void {
    this.app.view.fit();
    this.app.view.showAll();
  }

  /** Move the cursor, and in a recording the player; while aligning, use the moment for the comparison. */
  choose(time: number): void {
    this.app.cursors.a = time;
    if (!this.app.comparison.aligning) {
      if (this.app.display.source.kind === "recording") this.app.player.seek(time);
      return;
    }
    this.app.comparison.alignAt(time);
    // The moment on the dashed line stays marked until the alignment is done.
    this.app.cursors.b = this.app.comparison.aligning ? time : null;
  }

  private middle(): number {
    return this.app.cursors.a ?? (this.app.view.window()[0] + this.app.view.window()[1]) / 2;
  }

  private step(samples: number): void {
    const { columns } = this.app.display.source;
    const row = Math.min(columns.length - 1, Math.max(0, columns.rowAt(this.middle()) + samples));
    if (columns.length > 0) this.app.cursors.a = columns.times()[row]!;
  }

  private toGap(step: 1 | -1): void {
    const gap = nextGap(this.app.chartData.gapsIn(), this.app.chartData.moment ?? this.app.view.window()[0], step);
    if (!gap) return;
    const within = (gap.from + gap.to) / 2;
    this.app.view.bring(within);
    this.app.cursors.a = within;
  }

  /** Go to a moment: the window, the cursor and the player. */
  goTo(time: number): void {
    this.app.view.bring(time);
    this.choose(time);
  }

  toMarker(step: 1 | -1): void {
    const from = this.app.chartData.moment ?? this.app.view.window()[step > 0 ? 0 : 1];
    const mark = nextMark(markersOf(this.app.display.source.events), from, step);
    if (mark) this.goTo(mark.time);
  }

  private escape(): void {
    if (this.app.comparison.aligning) this.app.comparison.toggleAligning();
    else this.app.cursors.a = null;
    this.app.cursors.b = null;
  }

  private readonly arrow = (code: "ArrowLeft" | "ArrowRight", shift: boolean, samples: number): Binding => ({
    code,
    shift,
    show: `${shift ? "⇧" : ""}${samples < 0 ? "←" : "→"}`,
    text: () => t(samples < 0 ? "left" : "right"),
    run: () => this.step(samples),
  });

  readonly bindings = (): Binding[] => [
    { code: "KeyS", show: "S", text: () => t("stackLong"), run: () => (this.app.view.stacked = !this.app.view.stacked) },
    { code: "KeyC", show: "C", text: () => t("second"), run: () => this.app.view.toggleSecond() },
    { code: "KeyG", show: "G", text: () => t("nextGap"), run: () => this.toGap(1) },
    { code: "KeyG", shift: true, show: "⇧G", text: () => t("nextGap"), run: () => this.toGap(-1) },
    { code: "KeyN", show: "N", text: () => t("nextMarker"), run: () => this.toMarker(1) },
    { code: "KeyN", shift: true, show: "⇧N", text: () => t("previousMarker"), run: () => this.toMarker(-1) },
    { code: "NumpadDivide", key: "/", show: "/", text: () => findText("findLong"), run: () => (this.app.find.open = true) },
    { code: "Digit0", show: "0", text: () => t("fit"), run: () => this.fit() },
    { code: "Equal", show: "+", text: () => t("closer"), run: () => this.app.view.zoom(0.7, this.middle()) },
    { code: "Minus", show: "−", text: () => t("farther"), run: () => this.app.view.zoom(1 / 0.7, this.middle()) },
    { code: "Escape", show: "Esc", text: () => t("noCursors"), run: () => this.escape() },
    this.arrow("ArrowLeft", false, -1),
    this.arrow("ArrowRight", false, 1),
    this.arrow("ArrowLeft", true, -10),
    this.arrow("ArrowRight", true, 10),
    ...(this.app.display.source.kind === "live" ? [this.newest] : []),
    ...(this.app.comparison.aligning ? [this.chosen] : []),
  ];

  /** For live data only: in a recording L is the loop. */
  private readonly newest: Binding = { code: "KeyL", show: "L", text: () => t("followLong"), run: () => this.app.view.follow() };

  /** Selects the moment at the cursor while aligning. */
  private readonly chosen: Binding = {
    code: "Enter",
    show: "Enter",
    text: () => t("chosen"),
    run: () => this.app.cursors.a !== null && this.choose(this.app.cursors.a),
  };
}
