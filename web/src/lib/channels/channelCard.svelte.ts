// Which channel's card is open. Any value on any screen opens it: `channelCard.open("TWAT")`, or with the moment that was touched.

export class ChannelCard {
  name = $state<string | null>(null);
  /** The moment whose value is shown; null: now, or the player's position. */
  at = $state<number | null>(null);

  open(name: string, at?: number): void {
    this.name = name;
    this.at = at ?? null;
  }

  close(): void {
    this.name = null;
    this.at = null;
  }
}
