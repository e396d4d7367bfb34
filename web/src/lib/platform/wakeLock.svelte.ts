// Keeps the screen on while live data come. The browser releases the lock when the page is hidden; it is taken again when the page is shown.
// Browsers give it only to encrypted pages and to this computer's own, so a phone over plain http does not get it.

export class WakeLock {
  /** `refused`: this browser or this connection cannot keep the screen on. */
  state = $state<"off" | "held" | "refused">("off");
  private wanted = false;
  private sentinel: WakeLockSentinel | null = null;

  constructor() {
    globalThis.document?.addEventListener("visibilitychange", () => void this.update());
  }

  /** Keep the screen on from now on, or no longer. */
  want(wanted: boolean): void {
    this.wanted = wanted;
    void this.update();
  }

  private async update(): Promise<void> {
    if (!this.wanted || document.hidden) {
      const held = this.sentinel;
      this.sentinel = null;
      this.state = "off";
      await held?.release().catch(() => undefined);
      return;
    }
    if (this.sentinel) return;
    try {
      const lock = await navigator.wakeLock.request("screen");
      // The wish may have ended meanwhile, or another request may have been faster.
      if (!this.wanted || document.hidden || this.sentinel) return await lock.release().catch(() => undefined);
      this.sentinel = lock;
      this.state = "held";
      lock.addEventListener("release", () => {
        if (this.sentinel === lock) {
          this.sentinel = null;
          this.state = "off";
        }
      });
    } catch {
      // `navigator.wakeLock` is missing, or the system refuses, for example with a nearly empty battery.
      if (this.wanted) this.state = "refused";
    }
  }
}
