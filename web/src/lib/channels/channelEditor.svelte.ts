// The sheet of a channel of one's own: `channelEditor.create()`, `channelEditor.edit("LOAD")`.

export class ChannelEditor {
  /** Null: closed; an empty name: a new channel. */
  name = $state<string | null>(null);
  private made: (name: string) => void = () => undefined;
  private readonly forgetting: ((name: string) => void)[] = [];

  /** Make a new channel; `made` is called with its name when it has been saved. */
  create(made: (name: string) => void = () => undefined): void {
    this.made = made;
    this.name = "";
  }

  edit(name: string): void {
    this.made = () => undefined;
    this.name = name;
  }

  saved(name: string): void {
    this.made(name);
    this.close();
  }

  /** `forget` is called with each deleted channel: for what would go on showing it. */
  whenDeleted(forget: (name: string) => void): void {
    this.forgetting.push(forget);
  }

  deleted(name: string): void {
    for (const forget of this.forgetting) forget(name);
    this.close();
  }

  close(): void {
    this.name = null;
  }
}
