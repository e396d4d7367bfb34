// The instruments beside the unit: which there are, and this device's own position, if it is one of them.
import { ApiRequest } from "../../../lib/api/request.svelte";
import { Resource } from "../../../lib/api/resource.svelte";
import type { InstrumentDefinition, Instruments, NewInstrument, OwnInstrument } from "../../../lib/api/types";
import { watch } from "../../../lib/platform/watch.svelte";
import type { Stores } from "../../../stores";
import { OwnPosition } from "./ownPosition.svelte";

/** The port of an instrument whose values a page sends. */
export const POSITION_PORT = "position:";

export class InstrumentStore {
  readonly list = new Resource<true, Instruments>({
    of: () => this.app.live.linked,
    again: () => this.app.live.state?.instruments_version,
    ask: () => this.app.api.instruments(),
    insists: true,
  });
  /** What a sheet asks for: its error is shown there, for a sheet covers the toasts. */
  readonly adding = new ApiRequest<Instruments>();
  readonly defining = new ApiRequest<Instruments>();
  /** Null: none is shown; `known` null: a new definition. */
  sheet = $state.raw<"add" | { known: InstrumentDefinition | null } | null>(null);
  readonly own = new OwnPosition((position) => this.app.api.sendPosition(position));
  /** The ports at which they are: none of them is the unit's. */
  readonly ports = $derived.by<ReadonlySet<string>>(() => new Set(this.list.value?.instruments.map(({ port }) => port)));
  /** Some device's position is an instrument. */
  readonly takesPosition = $derived.by(() => this.list.value?.instruments.some(({ port }) => port === POSITION_PORT) ?? false);

  constructor(private readonly app: Pick<Stores, "api" | "catalog" | "live" | "player" | "toasts">) {}

  /** For the frame while it is initialised: the channels are known on every screen, and the position is sent from each. */
  follow(): void {
    this.list.need();
    watch(
      () => this.list.value,
      (found) => {
        this.app.catalog.beside = found?.channels ?? [];
        this.app.catalog.besideOnce = found ? [...found.known, ...found.definitions.flatMap(({ channels }) => channels)] : [];
      },
    );
    watch(
      () => this.app.player.shown,
      (shown) => (this.app.catalog.recorded = shown?.instruments ?? []),
    );
    watch(
      () => this.takesPosition && this.own.wanted && this.app.live.link === "open",
      (sending) => (sending ? this.own.start() : undefined),
    );
  }

  /** Read one more. Returns whether it succeeded; `adding.error` says why not. */
  async add(instrument: NewInstrument): Promise<boolean> {
    return this.take(await this.adding.run(() => this.app.api.addInstrument(instrument)));
  }

  async remove(name: string): Promise<boolean> {
    return this.use(() => this.app.api.removeInstrument(name));
  }

  /** Keep a definition. Returns whether it succeeded; `defining.error` says why not. */
  async define(name: string, definition: OwnInstrument): Promise<boolean> {
    return this.take(await this.defining.run(() => this.app.api.defineInstrument(name, definition)));
  }

  async forget(name: string): Promise<boolean> {
    return this.use(() => this.app.api.forgetDefinition(name));
  }

  private async use(make: () => Promise<Instruments>): Promise<boolean> {
    return this.take(await this.app.toasts.attempt(make));
  }

  private take(found: Instruments | undefined): boolean {
    if (found) this.list.value = found;
    return found !== undefined;
  }
}
