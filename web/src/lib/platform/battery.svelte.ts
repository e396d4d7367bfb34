// The battery of a phone. Its one socket feeds the cable, so it is not charged there meanwhile. Chrome says how full it is; where a browser does not,
// nothing is shown and nothing is done.
import { holdsAdapter } from "../live/lineState";
import type { Stores } from "../../stores";

/** What Chrome gives; `level` from 0 to 1. */
export interface BatteryManager extends EventTarget {
  readonly level: number;
  readonly charging: boolean;
}

declare global {
  interface Navigator {
    getBattery?(): Promise<BatteryManager>;
  }
}

export class Battery {
  /** Null: the browser does not say. */
  private percent = $state<number | null>(null);
  private charging = $state(false);
  private readonly feeds = $derived.by(() => {
    const { host, live } = this.app;
    return host.feedsAdapters && live.state !== null && holdsAdapter(live.state);
  });
  /** Percent left while the device feeds a cable and is not charged; null: there is nothing to care about. */
  readonly left = $derived.by(() => (this.feeds && !this.charging ? this.percent : null));

  constructor(private readonly app: Pick<Stores, "host" | "live">) {}

  /** Follow it from now on, where it matters. */
  async follow(): Promise<void> {
    if (!this.app.host.feedsAdapters) return;
    try {
      const battery = await globalThis.navigator.getBattery?.();
      if (!battery) return;
      const look = () => {
        this.percent = Math.round(battery.level * 100);
        this.charging = battery.charging;
      };
      battery.addEventListener("levelchange", look);
      battery.addEventListener("chargingchange", look);
      look();
    } catch {
      // The browser keeps it to itself.
    }
  }
}
