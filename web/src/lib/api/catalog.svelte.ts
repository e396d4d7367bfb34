// The catalog: every channel with its name, unit and limits. It is loaded once; it does not change while the program runs.
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

  /** Load the catalog, with retries until it has come or the returned function is called. */
  load(): () => void {
    return retry(async () => (this.loaded = await api.catalog()));
  }

  get(name: string): Channel | undefined {
    return this.byName.get(name);
  }
}

export const catalog = new CatalogStore();
