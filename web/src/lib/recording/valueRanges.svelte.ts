// Of each channel the lowest and the highest value in a recording: one of the user's, or the virtual car at warm idle, which is not measured
// on an engine and is named so where it is shown.
import type { Stores } from "../../stores";
import { Resource } from "../api/resource.svelte";
import type { RecordingRows } from "../api/types";

export type Band = readonly [low: number, high: number];
type Bands = ReadonlyMap<string, Band>;

/** Stands for the recording of the connected model's virtual car; no file's name has a colon. */
export const WARM_IDLE = "virtual:warm-idle";
export const NO_BANDS: Bands = new Map();
/** Of a longer recording extremes are sent. */
const POINTS = 4000;

export class ValueRanges extends Resource<readonly [id: string, model: string, version: string], Bands> {
  /** `id`: the recording's, or `WARM_IDLE`, which the program makes the first time: that takes seconds. Asked for once for each catalog. */
  constructor({ api, catalog, live }: Pick<Stores, "api" | "catalog" | "live">, id: () => string | null) {
    const virtualOf = async (model: string) => {
      const virtual = (await api.references()).virtual.filter(({ id }) => id.startsWith(`${WARM_IDLE}:`));
      return (virtual.find((it) => model.includes(it.model)) ?? virtual[0])?.id;
    };
    super({
      of: () => {
        const [it, version] = [id(), catalog.loaded?.version ?? ""];
        return it === null ? null : [it, it === WARM_IDLE ? (live.state?.model?.en ?? "") : "", version];
      },
      ask: async ([it, model]) => {
        const recording = it === WARM_IDLE ? await virtualOf(model) : it;
        return recording === undefined ? NO_BANDS : bandsOf(await api.rows(recording, { from: null, to: null, points: POINTS }));
      },
      once: true,
    });
  }

  get bands(): Bands {
    return this.value ?? NO_BANDS;
  }
}

export function bandsOf({ names, values }: Pick<RecordingRows, "names" | "values">): Map<string, Band> {
  const bands = new Map<string, Band>();
  names.forEach((name, index) => {
    const found = (values[index] ?? []).filter((value) => value !== null);
    if (found.length > 0) bands.set(name, [Math.min(...found), Math.max(...found)]);
  });
  return bands;
}
