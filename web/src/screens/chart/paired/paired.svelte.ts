// Pairs of the rows of a source, found in slices of a frame and handed to a consumer (the cells of a table, a cloud) as they come.
import { Pairs, type PairPlan } from "../../../lib/pairs/pairs";
import { gapsOf, type Data } from "./data.svelte";

/** Rows, or pairs, of one step. */
const PORTION = 4096;
/** ms of a frame for the steps; drawing and input need the rest. */
const BUDGET = 7;

export interface Consumer {
  take(pairs: Pairs, most: number): boolean;
}

export class Paired {
  /** Counts slices that changed something. */
  tick = $state(0);
  private found: Pairs | null = null;
  /** The share of the rows that has been read. */
  share = $state(0);
  finished = $state(false);
  /** Makes the consumer for new pairs. */
  private consumer: Consumer | null = null;
  private data: Data | null = null;
  private key = "";
  private frame = 0;

  /** Others after each slice. */
  get pairs(): Pairs | null {
    return this.tick >= 0 ? this.found : null;
  }

  /** Pair these rows; another plan or other rows start from the beginning. Returns whether they did. */
  begin(plan: Omit<PairPlan, "span">, data: Data | null): boolean {
    const usable = data && !data.problem ? data : null;
    const key = JSON.stringify([plan, usable?.span, usable !== null]);
    const same = key === this.key && usable?.columns === this.data?.columns;
    this.key = key;
    this.data = usable;
    if (same && !(usable && this.found?.isOutdated(usable.columns))) {
      if (usable?.grows) this.request();
      return false;
    }
    this.stop();
    this.found = usable ? new Pairs({ ...plan, span: usable.span }) : null;
    this.consumer = null;
    this.share = 0;
    this.finished = false;
    this.tick += 1;
    if (usable) this.request();
    return true;
  }

  /** Hand the pairs to this consumer, from the first one on. */
  feed(consumer: Consumer): void {
    this.consumer = consumer;
    if (this.found) this.request();
  }

  end(): void {
    this.stop();
    this.key = "";
  }

  /** Go on in the next frame. */
  private request(): void {
    this.frame ||= requestAnimationFrame(() => this.slice());
  }

  private stop(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
  }

  private slice(): void {
    this.frame = 0;
    const end = performance.now() + BUDGET;
    let more = this.step();
    while (more && performance.now() < end) more = this.step();
    if (this.data && this.found) this.share = this.found.share(this.data.columns);
    this.finished = !more;
    this.tick += 1;
    if (more) this.request();
  }

  /** Do a small part; whether more is left. */
  private step(): boolean {
    const { found: pairs, data } = this;
    if (!pairs || !data) return false;
    const more = pairs.read(data.columns, gapsOf(data.events), PORTION);
    return (this.consumer?.take(pairs, PORTION) ?? false) || more;
  }
}
