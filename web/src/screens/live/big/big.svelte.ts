// Big numbers: whether they are shown, and the values of the preset; both stored in this browser.
import { catalog } from "../../../lib/api/catalog.svelte";
import { loadSetting, saveSetting } from "../../../lib/platform/storage";
import { MOST, storedNames, usualNames } from "./bigNumbers";
import { presets } from "../presets.svelte";

class Big {
  on = $state(loadSetting("big") === "on");
  /** Counts changes of the stored names. */
  private changes = $state(0);

  /** Whether others than the usual values are chosen. */
  readonly own = $derived.by(() => (void this.changes, storedNames(loadSetting(this.key), catalog.channels)));
  readonly names = $derived<string[]>(this.own ?? (presets.onScreen ? usualNames(presets.onScreen, catalog.channels) : []));

  private get key(): string {
    return `big.${presets.onScreen?.id ?? ""}`;
  }

  toggle(): void {
    this.on = !this.on;
    saveSetting("big", this.on ? "on" : "off");
  }

  /** Show the value, or no longer; the last one stays. */
  switch(name: string): void {
    const names = this.names.includes(name) ? this.names.filter((one) => one !== name) : [...this.names, name];
    if (names.length > 0 && names.length <= MOST) this.store(JSON.stringify(names));
  }

  reset(): void {
    this.store("");
  }

  private store(text: string): void {
    saveSetting(this.key, text);
    this.changes += 1;
  }
}

export const big = new Big();
