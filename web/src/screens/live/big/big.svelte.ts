// Big numbers: whether they are shown, and the values of the preset; both stored in this browser.
import { loadSetting, saveSetting } from "../../../lib/platform/storage";
import { MOST, storedNames, usualNames } from "./bigNumbers";
import type { Stores } from "../../../stores";

export class Big {
  on = $state(loadSetting("big") === "on");
  /** Counts changes of the stored names. */
  private changes = $state(0);

  /** Whether others than the usual values are chosen. */
  readonly own = $derived.by(() => (void this.changes, storedNames(loadSetting(this.key), this.app.catalog.channels)));
  readonly names = $derived.by<string[]>(
    () =>
      this.own ??
      (this.app.presets.onScreen ? usualNames(this.app.presets.onScreen, this.app.absent.without(this.app.catalog.channels)) : []),
  );

  constructor(private readonly app: Pick<Stores, "absent" | "catalog" | "presets">) {}

  private get key(): string {
    return `big.${this.app.presets.onScreen?.id ?? ""}`;
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
