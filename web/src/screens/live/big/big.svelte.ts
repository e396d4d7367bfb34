// Big numbers: whether they are shown, and the values of the preset; both stored in this browser. A phone on its side has room for little else.
import { loadSetting, saveSetting } from "../../../lib/platform/storage";
import { lying } from "../../../lib/platform/viewport";
import { MOST, storedNames, usualNames } from "./bigNumbers";
import type { Stores } from "../../../stores";

export class Big {
  /** Chosen by a person, with the phone upright (or elsewhere) and on its side. */
  private chosen = $state({ big: loadSetting("big"), "big-lying": loadSetting("big-lying") });
  /** Counts changes of the stored names. */
  private changes = $state(0);

  /** Whether others than the usual values are chosen. */
  readonly own = $derived.by(() => (void this.changes, storedNames(loadSetting(this.key), this.app.catalog.channels)));
  readonly names = $derived.by<string[]>(
    () =>
      this.own ??
      (this.app.presets.onScreen ? usualNames(this.app.presets.onScreen, this.app.absent.without(this.app.catalog.channels)) : []),
  );

  /** On a phone that lies on its side they are what is shown, until a person chooses otherwise there. */
  readonly on = $derived.by(() => (lying.current ? this.chosen["big-lying"] !== "off" : this.chosen.big === "on"));

  constructor(private readonly app: Pick<Stores, "absent" | "catalog" | "presets">) {}

  private get key(): string {
    return `big.${this.app.presets.onScreen?.id ?? ""}`;
  }

  toggle(): void {
    const position = lying.current ? "big-lying" : "big";
    const choice = this.on ? "off" : "on";
    this.chosen[position] = choice;
    saveSetting(position, choice);
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
