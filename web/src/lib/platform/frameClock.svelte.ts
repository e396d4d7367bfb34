// When to draw. Effects that show values read `frameClock.fast`, those that draw small pictures read `frameClock.slow`; both stop while the
// page is hidden. Fast: the frame after data arrived, at most 30 a second, and 4 a second without data (ages advance). Slow: 5 a second.

const FAST = 1000 / 30;
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

  /** Request a frame: there is something new. */
  request(): void {
    if (this.pending || !globalThis.document || document.hidden) return;
    this.pending = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  private frame(now: number): void {
    this.pending = false;
    // A frame that is slightly early still counts.
    if (now - this.lastFast < FAST - 4) return this.request();
    this.lastFast = now;
    this.fast += 1;
    if (now - this.lastSlow < SLOW) return;
    this.lastSlow = now;
    this.slow += 1;
  }
}

export const frameClock = new FrameClock();
