// The healthy virtual car at warm idle: of each channel the lowest and the highest value. Not measured on an engine, and named so where shown.
import { api } from "../api/api";
import { catalog } from "../api/catalog.svelte";
import { live } from "../live/live.svelte";

type Band = readonly [number, number];

/** More than the rows of the recording, so that none is left out. */
const POINTS = 4000;

class WarmIdle {
  bands = $state.raw<ReadonlyMap<string, Band>>(new Map());
  private loaded = "";

  /** Load the bands of the connected model, once for each catalog. The first time the program makes the recording, which takes seconds. */
  async load(): Promise<void> {
    const model = live.state?.model?.en ?? "";
    const wanted = `${model} ${catalog.loaded?.version}`;
    if (wanted === this.loaded) return;
    this.loaded = wanted;
    this.bands = new Map();
    try {
      const virtual = (await api.references()).virtual.filter(({ id }) => id.startsWith("virtual:warm-idle:"));
      const reference = virtual.find((it) => model.includes(it.model)) ?? virtual[0];
      if (!reference) return;
      const rows = await api.rows(reference.id, { from: null, to: null, points: POINTS });
      if (wanted === this.loaded) this.bands = bandsOf(rows);
    } catch {
      this.loaded = ""; // the next card tries again
    }
  }
}

export function bandsOf({ names, values }: { names: readonly string[]; values: readonly (readonly (number | null)[])[] }): Map<string, Band> {
  const bands = new Map<string, Band>();
  names.forEach((name, index) => {
    const found = (values[index] ?? []).filter((value) => value !== null);
    if (found.length > 0) bands.set(name, [Math.min(...found), Math.max(...found)]);
  });
  return bands;
}

export const warmIdle = new WarmIdle();
