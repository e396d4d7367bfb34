// Full screen: the page without band and navigation. Where the browser has no such function (iPhone) or refuses, the page still fills its window.

export class FullScreen {
  on = $state(false);
  /** The browser is in full screen, too. */
  private real = false;

  constructor() {
    globalThis.document?.addEventListener("fullscreenchange", () => {
      if (this.real && !document.fullscreenElement) this.on = this.real = false;
    });
  }

  async enter(): Promise<void> {
    this.on = true;
    try {
      await document.documentElement.requestFullscreen();
      this.real = true;
      if (!this.on) void document.exitFullscreen();
    } catch {
      // The page fills its window.
    }
  }

  leave(): void {
    this.on = false;
    if (document.fullscreenElement) void document.exitFullscreen();
  }

  toggle(): void {
    if (this.on) this.leave();
    else void this.enter();
  }
}
