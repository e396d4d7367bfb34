// Of each channel the lowest and the highest value in a recording: one of the user's, or the virtual car at warm idle, which is not measured
// on an engine and is named so where it is shown.
import { ApiRequest } from "../api/request.svelte";
import type { ApiClient } from "../api/api";
import type { CatalogStore } from "../api/catalog.svelte";
import type { Live } from "../live/live.svelte";

export type Band = readonly [low: number, high: number];
type Bands = ReadonlyMap<string, Band>;

/** Stands for the recording of the connected model's virtual car; no file's name has a colon. */
export const WARM_IDLE = "virtual:warm-idle";
export const NO_BANDS: Bands = new Map();
/** Of a longer recording extremes are sent. */
const POINTS = 4000;

export class ValueRanges extends ApiRequest<Bands> {
  private of = "";
  /** An effect that loads depends on this and on the catalog, not on the whole state, which comes twice a second: a failed load would be repeated. */
  private readonly model = $derived.by(() => this.live.state?.model?.en ?? "");

  constructor(
    private readonly api: ApiClient,
    private readonly catalog: CatalogStore,
    private readonly live: Live,
  ) {
    super();
  }

  get bands(): Bands {
    return this.value ?? NO_BANDS;
  }

  /** Load those of a recording, once for each catalog. The first time the program makes the virtual car's, which takes seconds. */
  async load(id: string): Promise<void> {
    const model = id === WARM_IDLE ? this.model : "";
    const of = `${id} ${model} ${this.catalog.loaded?.version}`;
    if (of === this.of) return;
    this.of = of;
    this.value = null;
    await this.run(async () => {
      const recording = id === WARM_IDLE ? await this.virtualOf(model) : id;
      return recording === undefined ? NO_BANDS : bandsOf(await this.api.rows(recording, { from: null, to: null, points: POINTS }));
    });
    if (this.error && of === this.of) this.of = ""; // the next one tries again
  }

  private async virtualOf(model: string): Promise<string | undefined> {
    const virtual = (await this.api.references()).virtual.filter(({ id }) => id.startsWith(`${WARM_IDLE}:`));
    return (virtual.find((it) => model.includes(it.model)) ?? virtual[0])?.id;
  }
}

export function bandsOf({
  names,
  values,
}: {
  names: readonly string[];
  values: readonly (readonly (number | null)[])[];
}): Map<string, Band> {
  const bands = new Map<string, Band>();
  names.forEach((name, index) => {
    const found = (values[index] ?? []).filter((value) => value !== null);
    if (found.length > 0) bands.set(name, [Math.min(...found), Math.max(...found)]);
  });
  return bands;
}
