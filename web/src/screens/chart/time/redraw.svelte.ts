// When the time chart is drawn: in an animation frame, only after a change, and not more often than a pixel moves. The window follows playback.
import { onDestroy } from "svelte";
import { useStores } from "../../../stores";
import { frameClock } from "../../../lib/platform/frameClock.svelte";
import { theme } from "../../../lib/platform/theme.svelte";
import { watch } from "../../../lib/platform/watch.svelte";

/** ms between two drawings caused by new data. */
const MIN_INTERVAL = 125;

/** To be made while a component is initialised: it ends with that component. */
export class Redraw {
  private readonly stores = useStores();
  /** The window that was drawn last. */
  span = $state.raw<[number, number]>(this.stores.view.window());
  private frame = 0;
  private drawn = 0;
  private position = NaN;

  /** `draw` draws the panes from one time to another; `width`: of the chart in pixels. */
  constructor(
    private readonly draw: (from: number, to: number) => void,
    private readonly width: () => number,
  ) {
    const { comparison, display, live, reference, view } = this.stores;
    // Changed by a person or the program: draw at once.
    watch(
      () => [view.span, view.end, view.stacked, view.stretches, view.panes, theme.tone, reference.bands, live.historyLoads, shown()],
      () => this.request(),
    );
    const shown = () => {
      const { source } = display;
      return source.kind === "recording" ? [source.tick, source.paused, comparison.tick, comparison.lag] : [source.paused];
    };
    watch(
      () => frameClock.fast,
      () => (display.source.kind === "recording" ? this.followPlayback() : this.followLive()),
    );
    onDestroy(() => cancelAnimationFrame(this.frame));
  }

  /** Draw in the next frame. */
  request(): void {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      this.drawn = performance.now();
      this.span = this.stores.view.window();
      this.draw(...this.span);
    });
  }

  /** New data: draw when it moves by a pixel, at most eight times a second, because drawing lines is expensive. */
  private followLive(): void {
    const { display, view } = this.stores;
    if (display.source.paused || view.end !== null) return;
    const pixel = (view.span / (this.width() || 1000)) * 1000;
    if (performance.now() - this.drawn < Math.min(1000, Math.max(MIN_INTERVAL, pixel) - 4)) return;
    view.grow();
    this.request();
  }

  /** Move the window when playback or the slider leaves it. */
  private followPlayback(): void {
    const { display, view } = this.stores;
    const now = display.source.now();
    const moved = now !== this.position;
    this.position = now;
    if (view.end === null || !moved) return;
    if (!display.source.paused && (now > view.end - view.span * 0.05 || now < view.end - view.span))
      view.show(now - view.span * 0.15, now + view.span * 0.85);
    else view.bring(now);
  }
}
