// The room for recordings in this browser.
import type { Stores } from "../../stores";
import { keepsFiles } from "../boot/keepsFiles";

/** Bytes: below that little is left; hours of recording are some ten million. */
const LITTLE = 300_000_000;

class Storage {
  /** Whether this browser keeps files for the page at all. */
  kept = $state(true);
  /** Bytes that are left for this page; null: not known. */
  left = $state<number | null>(null);
  private asked = false;

  async look(): Promise<void> {
    this.kept = await keepsFiles();
    if (!this.kept) return;
    const { quota, usage = 0 } = await navigator.storage.estimate();
    this.left = quota === undefined ? null : Math.max(0, quota - usage);
  }

  get isLittle(): boolean {
    return this.left !== null && this.left < LITTLE;
  }

  /** Ask the browser not to clear the recordings when the disk fills: when the first one is made, not before. Inside an effect. */
  watch({ live }: Stores): void {
    $effect(() => {
      if (!live.state?.recording || this.asked) return;
      this.asked = true;
      void navigator.storage?.persist?.().catch(() => false);
      void this.look();
    });
  }
}

export const storage = new Storage();
