// The cloud of the displayed source and, behind it, that of the second recording, at one scale: which points, which ranges are visible.
import { Cloud, type Frame } from "../../../lib/pairs/cloud";
import type { PairPlan } from "../../../lib/pairs/pairs";
import { countWhile } from "../../../lib/series/columns";
import { axisAlone } from "../../../lib/series/valueAxis";
import { useStores } from "../../../stores";
import type { Data } from "../paired/data.svelte";
import { Paired } from "../paired/paired.svelte";
import { moved, zoomed } from "./picture";
import type { Source } from "../../../lib/display/source.svelte";

/** Ranges narrower than this share of their values, or wider than this, are not shown. */
const NARROWEST = 1e-6;
const WIDEST = 1e7;

type Place = readonly [number, number];

/** To be made while a component is initialised. */
export class Clouds {
  private readonly stores = useStores();
  readonly first = new Paired();
  readonly second = new Paired();
  cloud = $state.raw<Cloud | null>(null);
  behind: Cloud | null = null;
  /** The visible ranges that a person chose; null: everything. */
  chosen = $state.raw<Frame | null>(null);
  /** A cloud that is no longer used, for its memory. */
  private spare: Cloud | null = null;
  private x = "";
  private y = "";
  private source: Source | null = null;
  private grows = false;
  private whole = false;

  /** `plan`: y with the partners x and perhaps a colour. */
  begin(plan: Omit<PairPlan, "span">, own: Data, beside: Data | null, source: Source): void {
    const x = plan.partners[0]!.name;
    // Other axes show everything again.
    if (plan.name !== this.y || x !== this.x || source !== this.source) this.chosen = null;
    this.source = source;
    this.y = plan.name;
    this.x = x;
    this.grows = own.grows;
    this.whole = own.span === null;
    if (this.first.begin(plan, own)) {
      this.spare = this.cloud;
      this.cloud = null;
    }
    if (this.second.begin({ ...plan, partners: plan.partners.slice(0, 1) }, beside)) this.behind = null;
  }

  end(): void {
    this.first.end();
    this.second.end();
  }

  /** Make the clouds anew if size or ranges have changed. Returns whether it did: their points come in the next frames. */
  prepare(width: number, height: number): boolean {
    const { cloud, chosen } = this;
    const fits = cloud?.width === width && cloud.height === height;
    const all = this.everything();
    const stays = cloud && fits && contains(cloud.frame, all) && !isFarWider(cloud.frame, all);
    const frame = chosen ?? (stays ? cloud.frame : this.grows ? wider(all) : all);
    if (fits && cloud.frame === frame && (this.behind || !this.second.pairs)) return false;
    this.cloud = new Cloud(width, height, frame, this.spare ?? cloud);
    this.spare = null;
    this.behind = this.second.pairs ? new Cloud(width, height, frame, this.behind) : null;
    this.first.feed(this.cloud);
    if (this.behind) this.second.feed(this.behind);
    return true;
  }

  /** Zoom around a place given in shares of the plot, from the left and from the bottom. */
  zoom(factor: number, [across, up]: Place): void {
    if (!this.cloud) return;
    const { x, y } = this.cloud.frame;
    const next = { x: zoomed(x, factor, across), y: zoomed(y, factor, up) };
    if (isUsable(next.x) && isUsable(next.y)) this.chosen = next;
  }

  /** Move by pixels. */
  pan(across: number, down: number): void {
    if (!this.cloud) return;
    const { frame, width, height } = this.cloud;
    this.chosen = { x: moved(frame.x, across / width), y: moved(frame.y, -down / height) };
  }

  /** The number of the last pair at or before a time, if it is at most a second old; −1: none. */
  pairAt(time: number): number {
    const { pairs } = this.first;
    if (!pairs) return -1;
    const last = countWhile(pairs.length, (at) => pairs.times[at]! <= time) - 1;
    return last >= 0 && time - pairs.times[last]! <= 1 ? last : -1;
  }

  /** The ranges with all points. Before they are counted: those of the whole source, so that the picture does not grow meanwhile. */
  private everything(): Frame {
    const { first, second } = this;
    const range = (name: string, at: number): [number, number] => {
      let low = Math.min(first.pairs?.low[at] ?? Infinity, second.pairs?.low[at] ?? Infinity);
      let high = Math.max(first.pairs?.high[at] ?? -Infinity, second.pairs?.high[at] ?? -Infinity);
      const known = this.whole && !first.finished ? this.stores.display.source.extremes(name) : undefined;
      if (known) [low, high] = [Math.min(low, known.min), Math.max(high, known.max)];
      if (!(low <= high)) return [0, 1];
      const axis = axisAlone(this.stores.catalog.get(name), { min: low, max: high });
      return [axis.low, axis.high];
    };
    return { x: range(this.x, 1), y: range(this.y, 0) };
  }
}

const extent = ([low, high]: readonly [number, number]) => high - low;
const holds = (outer: readonly [number, number], inner: readonly [number, number]) => outer[0] <= inner[0] && outer[1] >= inner[1];
const contains = (frame: Frame, all: Frame) => holds(frame.x, all.x) && holds(frame.y, all.y);
const isFarWider = (frame: Frame, all: Frame) => extent(frame.x) > 1.5 * extent(all.x) || extent(frame.y) > 1.5 * extent(all.y);
const isUsable = (range: readonly [number, number]) =>
  extent(range) > NARROWEST * Math.max(1, Math.abs(range[0])) && extent(range) < WIDEST;
/** Room for values to come, so that live data do not draw the cloud anew with each new extreme. */
const wider = ({ x, y }: Frame): Frame => ({ x: zoomed(x, 1.1, 0.5), y: zoomed(y, 1.1, 0.5) });
