// Installing the page as an application of the computer, where the browser offers it.

/** Chromium's event, which TypeScript does not know. */
interface InstallPrompt extends Event {
  prompt(): Promise<unknown>;
}
declare global {
  interface WindowEventMap {
    beforeinstallprompt: InstallPrompt;
  }
}

class Installing {
  possible = $state(false);
  private offer: InstallPrompt | null = null;

  /** Call early: the browser offers once. */
  watch(): void {
    window.addEventListener("beforeinstallprompt", (event) => {
      event.preventDefault(); // no banner over the screen: there is a button
      this.offer = event;
      this.possible = true;
    });
    window.addEventListener("appinstalled", () => (this.possible = false));
  }

  async install(): Promise<void> {
    this.possible = false;
    await this.offer?.prompt();
  }
}

export const installing = new Installing();
