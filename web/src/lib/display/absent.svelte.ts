// The channels that the unit shown does not have: it controls the ignition alone. They are left out unless a person wants to see them.
import type { Display } from "./source.svelte";

export class AbsentChannels {
  /** They are shown all the same. */
  wanted = $state(false);
  /** Whether there are such channels: whether what is shown is of an ignition-only unit. */
  readonly any = $derived.by(() => this.names !== "");
  /** A text, which stays the same while each state names the same ones. */
  private readonly names = $derived.by(() => this.display.source.absent.join(" "));
  private readonly all = $derived.by<ReadonlySet<string>>(() => new Set(this.names.split(" ")));

  constructor(private readonly display: Display) {}

  /** Whether a channel is left out. */
  hides(name: string): boolean {
    return !this.wanted && this.has(name);
  }

  /** Whether the unit lacks a channel, also one that is shown all the same. */
  has(name: string): boolean {
    return this.all.has(name);
  }

  /** The channels, or names, that are not left out. */
  without<Item extends string | { readonly name: string }>(channels: readonly Item[]): Item[] {
    return channels.filter((each) => !this.hides(typeof each === "string" ? each : each.name));
  }
}
