// The service worker as the page sees it: the files are kept for a start without a network; a new version is loaded beside the one in use,
// and used when the user says so, or at the next start.
import type { Live } from "../../lib/live/live.svelte";

class Updates {
  /** All files are in this browser. */
  kept = $state(false);
  private waiting = $state.raw<ServiceWorker | null>(null);
  private asked = false;
  private live: Live | null = null;

  /** A new version is here, and nothing that it would interrupt goes on. */
  readonly offered = $derived.by(() => {
    const state = this.live?.state;
    return this.waiting !== null && state?.line !== "sampling" && !state?.recording;
  });

  /** Called after the start: the files that it loads are not loaded twice at the same time. */
  async watch(live: Live): Promise<void> {
    this.live = live;
    const workers = navigator.serviceWorker;
    if (!workers) return;
    workers.addEventListener("controllerchange", () => this.asked && location.reload());
    try {
      const registration = await workers.register("service-worker.js", { type: "module", updateViaCache: "none" });
      this.follow(registration);
      registration.addEventListener("updatefound", () => this.follow(registration));
      await workers.ready;
      this.kept = true;
    } catch {
      // Without it the page works as long as there is a network.
    }
  }

  use(): void {
    if (!this.offered) return;
    this.asked = true;
    this.waiting?.postMessage({ kind: "use" });
  }

  private follow(registration: ServiceWorkerRegistration): void {
    const next = registration.installing ?? registration.waiting;
    const look = () => {
      if (next?.state === "installed" && registration.active) this.waiting = next;
      else if (next === this.waiting) this.waiting = null;
    };
    next?.addEventListener("statechange", look);
    look();
  }
}

export const updates = new Updates();
