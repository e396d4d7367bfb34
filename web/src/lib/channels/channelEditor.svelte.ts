// The sheet of a channel of one's own: `channelEditor.create()`, `channelEditor.edit("LOAD")`.

export class ChannelEditor {
  /** Null: closed; an empty name: a new channel. */
  name = $state<string | null>(null);
  private made: (name: string) => void = () => undefined;
  /** Called with each deleted channel. */
  ondeleted: (name: string) => void = () => undefined;

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

  deleted(name: string): void {
    this.ondeleted(name);
    this.close();
  }

  close(): void {
    this.name = null;
  }
}
