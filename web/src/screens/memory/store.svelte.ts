// State of the Memory screen, kept while another screen is shown: the page of each space, the watched cells and their bytes.
import { Resource } from "../../lib/api/resource.svelte";
import { ApiRequest } from "../../lib/api/request.svelte";
import { loadSetting, saveSetting } from "../../lib/platform/storage";
import type { Dump, LeftOutFile, MemoryRead, Space } from "../../lib/api/types";
import { bytesOf, readsFor, restored, type Cell } from "./cells/cells";
import { Glow } from "./cells/glow";
import { SPACES, addressIn, addressText, fromHex, spaceOf, type Charset } from "./cells/hex";
import type { ApiClient } from "../../lib/api/api";

/** ms between two reads of the watched data, so that sampling continues. */
const PAUSE = 150;

/** The page of one space. */
export class View {
  typed = $state("0");
  count = $state(256);
  /** Address of the first byte shown, and the bytes. */
  first = $state(0);
  data = $state.raw<Uint8Array | null>(null);
  time = $state(0);
  chosen = $state<number | null>(null);
  readonly read = new ApiRequest<MemoryRead>();
  readonly glow = new Glow();

  constructor(
    private readonly api: ApiClient,
    readonly name: Space,
  ) {
    if (name === "sfr") [this.typed, this.count] = ["80", 128];
  }

  get address(): number | null {
    return addressIn(spaceOf(this.name), this.typed);
  }

  go(address: number): void {
    const space = spaceOf(this.name);
    this.typed = addressText(Math.max(0, Math.min(space.last, address)), space);
  }

  async refresh(): Promise<boolean> {
    const address = this.address;
    if (address === null) return false;
    const count = Math.min(this.count, spaceOf(this.name).last + 1 - address);
    const got = await this.read.run(() => this.api.memory(this.name, address, count));
    if (!got) return false;
    const data = fromHex(got.data);
    this.glow.take(data, got.address, performance.now());
    this.first = got.address;
    this.data = data;
    this.time = got.time;
    if (this.chosen !== null && (this.chosen < this.first || this.chosen >= this.first + data.length)) this.chosen = null;
    return true;
  }

  reset(): void {
    this.read.reset();
    this.glow.reset();
    this.data = null;
    this.chosen = null;
  }
}

export class MemoryStore {
  readonly views: Record<Space, View>;
  space = $state<Space>("ram");
  charset = $state<Charset>("cp866");
  /** Whether the page and the watched cells are read repeatedly. */
  following = $state(false);
  watching = $state(false);
  cells = $state.raw<Cell[]>(restored(loadSetting("cells")));
  bytes = $state.raw<ReadonlyMap<string, Uint8Array>>(new Map());
  readonly watched = new ApiRequest<true>();
  /** Asked for once a second while one is running. */
  readonly dumps: Resource<true, Dump[]> = new Resource({
    of: () => true,
    every: () => (this.dumps.value?.some((dump) => dump.state === "running") ? 1000 : 0),
    ask: async () => {
      const answer = await this.api.dumps();
      this.leftOut = answer.left_out;
      return answer.dumps;
    },
  });
  /** Files in the folder of dumps that are none. */
  leftOut = $state.raw<readonly LeftOutFile[]>([]);

  constructor(private readonly api: ApiClient) {
    const view = (name: Space) => new View(api, name);
    this.views = { ram: view("ram"), xram: view("xram"), code: view("code"), sfr: view("sfr") };
  }

  get view(): View {
    return this.views[this.space];
  }

  /** Another ECU is connected: drop the data of the previous one; the list of cells stays. */
  drop(): void {
    for (const { name } of SPACES) this.views[name].reset();
    this.bytes = new Map();
  }

  keepCell(cell: Cell): void {
    const known = this.cells.some((it) => it.id === cell.id);
    this.cells = known ? this.cells.map((it) => (it.id === cell.id ? cell : it)) : [...this.cells, cell];
    saveSetting("cells", JSON.stringify(this.cells));
  }

  dropCell(cell: Cell): void {
    this.cells = this.cells.filter((it) => it.id !== cell.id);
    saveSetting("cells", JSON.stringify(this.cells));
  }

  async readCells(): Promise<boolean> {
    const done = await this.watched.run(async () => {
      const bytes = new Map(this.bytes);
      for (const read of readsFor(this.cells)) {
        const got = await this.api.memory(read.space, read.address, read.count);
        const data = fromHex(got.data);
        for (const cell of read.cells) bytes.set(cell.id, bytesOf(cell, read, data));
      }
      this.bytes = bytes;
      return true as const;
    });
    return done === true;
  }

  /** Read repeatedly until `stop`; an error ends the loop and is shown. */
  follow(stop: AbortSignal): void {
    void (async () => {
      while (!stop.aborted && (this.following || this.watching)) {
        if (!document.hidden) {
          if (this.following && !(await this.view.refresh())) this.following = false;
          if (!stop.aborted && this.watching && !(await this.readCells())) this.watching = false;
        }
        await new Promise((go) => setTimeout(go, document.hidden ? 1000 : PAUSE));
      }
    })();
  }

  /** Replace one dump in the list. */
  put(dump: Dump): void {
    const others = this.dumps.value ?? [];
    this.dumps.value = others.some((it) => it.id === dump.id) ? others.map((it) => (it.id === dump.id ? dump : it)) : [dump, ...others];
  }

  /** Leave a deleted dump out at once; the list itself may take a while to come. */
  dropDeleted(id: string): void {
    this.dumps.value = this.dumps.value?.filter((it) => it.id !== id) ?? null;
    void this.dumps.reload();
  }
}
