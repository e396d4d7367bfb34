// The catalog: every channel with its name, unit and limits. The state names its version: it is loaded again after a change on any page.
import { valueText } from "../channels/valueText";
import { localized } from "../i18n";
import { recomputed } from "./recomputed";
import { Resource } from "./resource.svelte";
import type { Catalog, Channel } from "./types";
import type { Stores } from "../../stores";

export class CatalogStore {
  loaded = $state.raw<Catalog | null>(null);
  /** The channels that the program makes of the unit's responses. */
  readonly ofUnit = $derived<Channel[]>(this.loaded ? [...this.loaded.parameters, ...this.loaded.derived] : []);
  /** The channels of the instruments beside the unit. */
  beside = $state.raw<readonly Channel[]>([]);
  /** Those that instruments may have had in a recording. */
  besideOnce = $state.raw<readonly Channel[]>([]);
  /** Those of instruments in the recording that is shown. */
  recorded = $state.raw<readonly Channel[]>([]);
  readonly channels = $derived.by<Channel[]>(() => {
    const now = [...this.ofUnit, ...this.beside];
    return [...now, ...this.recorded.filter(({ name }) => !now.some((each) => each.name === name))];
  });
  /** The columns of another program's log while it is shown: they have names and units, and are no channels. */
  lent = $state.raw<readonly Channel[]>([]);
  private readonly byName = $derived(
    new Map([...this.besideOnce, ...this.channels, ...this.lent].map((channel) => [channel.name, channel])),
  );
  /** Called with the channels that a change computes otherwise, or that it has added or removed. */
  onrecomputed: (names: readonly string[]) => void = () => undefined;

  /** Asked for with each version that the state names, until it has come. */
  private readonly answer = new Resource({
    of: () => (this.app.live.link === "open" ? (this.app.live.state?.catalog ?? null) : null),
    ask: async (version: string, signal) => {
      if (this.loaded?.version === version) return;
      const next = await this.app.api.catalog();
      if (!signal.aborted) this.use(next);
    },
    insists: true,
  });

  constructor(private readonly app: Pick<Stores, "api" | "live" | "toasts">) {}

  /** For the frame: follow the program's catalog. */
  follow(): void {
    this.answer.need();
  }

  /** Use a catalog that the program has returned. */
  use(next: Catalog): void {
    const before = this.loaded;
    this.loaded = next;
    const names = before ? recomputed(before, next) : [];
    if (names.length > 0) this.onrecomputed(names);
  }

  /** Make a change that returns the catalog, and use that. Returns whether it succeeded; a toast has said so (`done`), or why not. */
  async change(make: () => Promise<Catalog>, done: () => string): Promise<boolean> {
    const next = await this.app.toasts.attempt(make);
    if (!next) return false;
    this.use(next);
    this.app.toasts.success(done);
    return true;
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
