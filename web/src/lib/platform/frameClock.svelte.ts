// When to draw. Effects that show values read `frameClock.fast`, those that draw small pictures read `frameClock.slow`; both stop while the
// page is hidden. Fast: the frame after data arrived, at most 20 a second, and 4 a second without data (ages advance). Slow: 5 a second.
// That is as often as the program sends, and digits that change more often can't be read. Between frames a timer waits: while an animation
// frame is requested the browser composes at the screen's own rate, and an early request costs that for nothing.

const FAST = 50;
/** A frame that is slightly early still counts: the next one is up to 17 ms later. */
const EARLY = 8;
const SLOW = 200;

class FrameClock {
  fast = $state(0);
  slow = $state(0);
  private pending = false;
  private lastFast = 0;
  private lastSlow = 0;

  constructor() {
    if (!globalThis.document) return;
    setInterval(() => this.request(), 250);
    document.addEventListener("visibilitychange", () => this.request());
  }

  /** What `read` returns now, in the place of a dependency on the clock: it is read again in each fast frame. */
  eachFrame<T>(read: () => T): T {
    return this.fast >= 0 ? read() : read();
  }

  /** The same with the slow clock. */
  slowly<T>(read: () => T): T {
    return this.slow >= 0 ? read() : read();
  }

  /** Request a frame: there is something new. */
  request(): void {
    if (this.pending || !globalThis.document || document.hidden) return;
    this.pending = true;
    // The page may have gone while the timer ran: a test ends, and its document with it.
    const draw = () => globalThis.document && requestAnimationFrame((now) => this.frame(now));
    const wait = this.lastFast + FAST - EARLY - performance.now();
    if (wait > 0) setTimeout(draw, wait);
    else draw();
  }

  private frame(now: number): void {
    this.pending = false;
    this.lastFast = now;
    this.fast += 1;
    if (now - this.lastSlow < SLOW - EARLY) return;
    this.lastSlow = now;
    this.slow += 1;
  }
}

export const frameClock = new FrameClock();
