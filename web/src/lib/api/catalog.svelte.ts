// The catalog: every channel with its name, unit and limits. The state names its version: it is loaded again after a change on any page.
import { valueText } from "../channels/valueText";
import { localized } from "../i18n";
import { recomputed } from "./recomputed";
import { retry } from "./retry";
import type { Catalog, Channel } from "./types";
import type { ApiClient } from "./api";

export class CatalogStore {
  loaded = $state.raw<Catalog | null>(null);
  readonly channels = $derived<Channel[]>(this.loaded ? [...this.loaded.parameters, ...this.loaded.derived] : []);
  private readonly byName = $derived(new Map(this.channels.map((channel) => [channel.name, channel])));
  /** Called with the channels that a change computes otherwise, or that it has added or removed. */
  onrecomputed: (names: readonly string[]) => void = () => undefined;

  constructor(private readonly api: ApiClient) {}

  /** Load the catalog of this version, with retries until it has come or the returned function is called. */
  follow(version: string): (() => void) | undefined {
    if (this.loaded?.version === version) return undefined;
    let current = true;
    const stop = retry(async () => {
      const next = await this.api.catalog();
      if (current) this.use(next);
    });
    return () => {
      current = false;
      stop();
    };
  }

  /** Use a catalog that the program has returned. */
  use(next: Catalog): void {
    const before = this.loaded;
    this.loaded = next;
    const names = before ? recomputed(before, next) : [];
    if (names.length > 0) this.onrecomputed(names);
  }

  get(name: string): Channel | undefined {
    return this.byName.get(name);
  }

  /** Short name. */
  nameOf(name: string): string {
    return localized(this.get(name)?.short) || name;
  }

  /** Short name with the unit. */
  titleOf(name: string): string {
    return [this.nameOf(name), localized(this.get(name)?.unit)].filter(Boolean).join(", ");
  }

  /** A measured value. */
  measured(name: string, value: number): string {
    const channel = this.get(name);
    return valueText(channel, Number.isFinite(value) ? value : null, channel?.decimals ?? 2);
  }
}
