// The kept files as another worker sees them that only reads: what `pool.ts` has open, looked at once more.
//
//     const view = await PoolView.open(await opfsFolder());   // after the pool was opened there
//     mount(pyodide.FS, "/kept", view);                       // every change there is refused: EROFS
//     await view.refresh();                                   // before each request: new, renamed, deleted, longer files

import { errno, FileError } from "./errors";
import type { Folder, View } from "./folder";
import { isSlotName, KeptFile, Slot, winners } from "./slot";

/** How often the headers are read again while the writer changes them. */
const MOST_PASSES = 8;

export class PoolView {
  /** Called after files were made, renamed or deleted. */
  onChange = (): void => {};
  readonly #slots = new Map<string, Slot>();
  readonly #views: View[] = []; // of all slots
  #files = new Map<string, ViewedFile>(); // by slot, id and path
  #seen = ""; // the same, of the last look
  #last = Promise.resolve();

  private constructor(private readonly folder: Folder) {}

  static async open(folder: Folder): Promise<PoolView> {
    const view = new PoolView(folder);
    await view.refresh();
    return view;
  }

  all(): Iterable<KeptFile> {
    return this.#files.values();
  }

  /** See what the writer has changed. */
  refresh(): Promise<void> {
    // One after another: each slot is opened once.
    this.#last = this.#last.catch(() => {}).then(() => this.#refresh());
    return this.#last;
  }

  close(): void {
    for (const view of this.#views.splice(0)) view.close();
    this.#slots.clear();
  }

  async #refresh(): Promise<void> {
    const names = (await this.folder.names()).filter(isSlotName);
    const added = names.filter((name) => !this.#slots.has(name));
    await Promise.all(this.#views.map((view) => view.renew()));
    await Promise.all(
      added.map(async (name) => {
        const view = await this.folder.view(name);
        this.#views.push(view);
        this.#slots.set(name, new Slot(name, view));
      }),
    );
    const former = this.#seen;
    const used = this.#look();
    for (const file of this.#files.values()) file.update();
    if (this.#seen === former) return;
    const files = used.map((slot) => {
      const file = this.#files.get(identity(slot)) ?? new ViewedFile(slot);
      return [identity(slot), file] as const;
    });
    this.#files = new Map(files);
    this.onChange();
  }

  /** Read the headers until they stay, so that a file that is renamed meanwhile is not missed. */
  #look(): Slot[] {
    let used: Slot[] = [];
    for (let pass = 0, before; before !== this.#seen && pass < MOST_PASSES; pass++) {
      before = this.#seen;
      used = this.#used();
      this.#seen = used.map(identity).join();
    }
    return used;
  }

  #used(): Slot[] {
    const slots = [...this.#slots.values()].filter((slot) => slot.load() === "used");
    return winners(slots).used;
  }
}

function identity(slot: Slot): string {
  return `${slot.name}/${slot.header.id}/${slot.header.path}`;
}

class ViewedFile extends KeptFile {
  update(): void {
    if (this.slot.header.id === this.id) this.mtime = this.slot.header.mtime;
  }

  /** Read; `ESTALE`: the file was deleted, and the bytes may be of another. */
  override read(into: Uint8Array, at: number): number {
    const length = super.read(into, at);
    if (this.slot.load() !== "used" || this.slot.header.id !== this.id) throw new FileError(errno.STALE);
    return length;
  }
}
