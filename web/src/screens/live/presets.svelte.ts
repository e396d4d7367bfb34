// The presets: shipped ones from the catalog, the user's own from the server; the selected one; the one being edited.
import { retry } from "../../lib/api/retry";
import { loadSetting, saveSetting } from "../../lib/platform/storage";
import type { Preset, Tile } from "../../lib/api/types";
import type { ApiClient } from "../../lib/api/api";
import type { CatalogStore } from "../../lib/api/catalog.svelte";
import type { Subscriptions } from "../../lib/control/subscriptions.svelte";

export class Presets {
  own = $state.raw<Preset[]>([]);
  loaded = $state(false);
  private id = $state(loadSetting("preset") ?? "idle");
  /** The edited copy, shown while editing. */
  draft = $state.raw<Preset | null>(null);

  readonly all = $derived.by<Preset[]>(() => [...(this.catalog.loaded?.presets ?? []), ...this.own]);
  readonly chosen = $derived<Preset | undefined>(this.all.find(({ id }) => id === this.id) ?? this.all[0]);
  readonly onScreen = $derived<Preset | undefined>(this.draft ?? this.chosen);
  /** Channels of the preset on the screen. */
  readonly names = $derived(this.onScreen ? this.namesOf(this.onScreen) : []);

  constructor(
    private readonly api: ApiClient,
    private readonly catalog: CatalogStore,
    private readonly subscriptions: Subscriptions,
  ) {}

  /** Load the user's presets, with retries until they have come or the returned function is called. */
  load(): () => void {
    return retry(async () => {
      this.own = (await this.api.presets()).presets;
      this.loaded = true;
    });
  }

  choose(id: string): void {
    this.id = id;
    this.draft = null;
    saveSetting("preset", id);
    if (this.chosen) this.subscriptions.setPreset(this.namesOf(this.chosen), true);
  }

  /** All channels of a preset; a table without names has every channel. */
  private namesOf(preset: Preset): string[] {
    const everything = ({ kind }: Tile) => (kind === "table" ? this.catalog.channels.map(({ name }) => name) : []);
    return [...new Set(preset.tiles.flatMap((tile) => (tile.names.length ? tile.names : everything(tile))))];
  }

  edit(): void {
    const from = this.chosen;
    if (!from) return;
    const name = from.shipped ? { en: `${from.name.en} 2`, ru: `${from.name.ru} 2` } : from.name;
    this.draft = { id: from.shipped ? newId(this.all) : from.id, name, shipped: false, tiles: from.tiles.map((tile) => ({ ...tile })) };
  }

  change(tiles: Tile[]): void {
    if (this.draft) this.draft = { ...this.draft, tiles };
  }

  async save(name: string): Promise<void> {
    const draft = this.draft;
    if (!draft) return;
    const isNew = !this.own.some(({ id }) => id === draft.id);
    let id = draft.id;
    await this.replace((own) => {
      // Another page may have taken the number.
      if (isNew) id = newId([...this.all, ...own]);
      const saved: Preset = { ...draft, id, name: { en: name, ru: name } };
      return own.some((preset) => preset.id === id) ? own.map((preset) => (preset.id === id ? saved : preset)) : [...own, saved];
    });
    this.choose(id);
  }

  async remove(): Promise<void> {
    const removed = this.draft ?? this.chosen;
    await this.replace((own) => own.filter(({ id }) => id !== removed?.id));
    this.choose(this.all[0]?.id ?? "idle");
  }

  /** All are saved together, so it starts from those that the program has now: another page may have saved some. */
  private async replace(change: (own: readonly Preset[]) => Preset[]): Promise<void> {
    const { presets } = await this.api.presets();
    this.own = (await this.api.savePresets(change(presets))).presets;
  }
}

function newId(taken: readonly Preset[]): string {
  for (let number = 1; ; number += 1) {
    const id = `own-${number}`;
    if (!taken.some((preset) => preset.id === id)) return id;
  }
}
