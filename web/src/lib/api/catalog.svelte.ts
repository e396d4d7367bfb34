// The catalog: what there is to measure, with names, units, limits; asked until it came, after that it does not change.
import { api } from "./api";
import { retry } from "./retry";
import type { Catalog, Channel } from "./types";

class CatalogStore {
  loaded = $state.raw<Catalog | null>(null);
  readonly channels = $derived<Channel[]>(
    this.loaded ? [...this.loaded.parameters, ...this.loaded.derived] : [],
  );
  private readonly byName = $derived(
    new Map(this.channels.map((channel) => [channel.name, channel])),
  );

  /** Until it came, or the returned function is called. Without it nothing on the page has a name. */
  load(): () => void {
    return retry(async () => (this.loaded = await api.catalog()));
  }

  get(name: string): Channel | undefined {
    return this.byName.get(name);
  }
}

export const catalog = new CatalogStore();
