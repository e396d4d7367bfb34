// The presets: shipped ones from the catalog, the user's own from the server; the selected one; the one being edited.
import { Resource } from "../../lib/api/resource.svelte";
import { loadSetting, saveSetting } from "../../lib/platform/storage";
import type { Preset, Tile } from "../../lib/api/types";
import type { Stores } from "../../stores";

export class Presets {
  own = $state.raw<Preset[]>([]);
  loaded = $state(false);
  private id = $state(loadSetting("preset") ?? "idle");
  /** The edited copy, shown while editing. */
  draft = $state.raw<Preset | null>(null);

  readonly all = $derived.by<Preset[]>(() => [...(this.app.catalog.loaded?.presets ?? []), ...this.own]);
  readonly chosen = $derived<Preset | undefined>(this.all.find(({ id }) => id === this.id) ?? this.all[0]);
  readonly onScreen = $derived<Preset | undefined>(this.draft ?? (this.chosen && this.present(this.chosen)));
  /** Channels of the preset on the screen. */
  readonly names = $derived(this.onScreen ? this.namesOf(this.onScreen) : []);

  private readonly first = new Resource({
    of: () => (this.app.live.link === "open" && !this.loaded ? true : null),
    ask: async () => {
      this.own = (await this.app.api.presets()).presets;
      this.loaded = true;
    },
    insists: true,
  });

  constructor(private readonly app: Pick<Stores, "absent" | "api" | "catalog" | "live" | "subscriptions">) {}

  /** For a component that shows them: load the user's presets, until they have come. */
  need(): void {
    this.first.need();
  }

  choose(id: string): void {
    this.id = id;
    this.draft = null;
    saveSetting("preset", id);
    if (this.onScreen) this.app.subscriptions.set("preset", this.namesOf(this.onScreen), true);
  }

  /** The preset without the channels that the unit does not have, and without tiles of these alone. */
  private present(preset: Preset): Preset {
    const { absent } = this.app;
    const tiles = preset.tiles.filter(({ names }) => !names.some((name) => absent.hides(name)) || absent.without(names).length > 0);
    return { ...preset, tiles: tiles.map((tile) => ({ ...tile, names: absent.without(tile.names) })) };
  }

  /** All channels of a preset; a table without names has every channel. */
  private namesOf(preset: Preset): string[] {
    const everything = ({ kind }: Tile) =>
      kind === "table" ? this.app.absent.without(this.app.catalog.channels).map(({ name }) => name) : [];
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
    const { presets } = await this.app.api.presets();
    this.own = (await this.app.api.savePresets(change(presets))).presets;
  }
}

function newId(taken: readonly Preset[]): string {
  for (let number = 1; ; number += 1) {
    const id = `own-${number}`;
    if (!taken.some((preset) => preset.id === id)) return id;
  }
}
