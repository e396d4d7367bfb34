// When to draw. What shows values reads `frameClock.fast`, what draws small pictures reads `frameClock.slow`; both stand still while the page is hidden,
// so that a forgotten tab costs nothing. Fast: the frame after data came, at most 30 times a second, and 4 times a second without data
// (ages go on). Slow: 5 times a second.

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

  /** There is something new. */
  request(): void {
    if (this.pending || !globalThis.document || document.hidden) return;
    this.pending = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  private frame(now: number): void {
    this.pending = false;
    // A frame early by a hair is not worth a whole frame more.
    if (now - this.lastFast < FAST - 4) return this.request();
    this.lastFast = now;
    this.fast += 1;
    if (now - this.lastSlow < SLOW) return;
    this.lastSlow = now;
    this.slow += 1;
  }
}

export const frameClock = new FrameClock();
