// Moments found somewhere (a cell of a table, points of a cloud), marked in the time chart; one of them is the current one. They belong to the
// source in which they were found.
import type { Stretch } from "../pairs/stretches";
import { countWhile } from "../series/columns";
import type { Cursors } from "./cursors.svelte";

export class Moments {
  /** What was looked for, as it is shown: in the language of now. */
  title = $state.raw<() => string>(() => "");
  list = $state.raw<readonly Stretch[]>([]);
  /** The view of the chart in which they were found. */
  origin = $state<"scatter" | "table" | null>(null);
  /** The current one's number; −1: none yet. */
  at = $state(-1);
  /** Called with the moment that becomes the current one. */
  onturn: (moment: Stretch) => void = () => undefined;

  constructor(private readonly cursors: Cursors) {}

  get current(): Stretch | undefined {
    return this.list[this.at];
  }

  /** Mark these, in the order of time; the first one becomes the current one. */
  mark(title: () => string, list: readonly Stretch[], origin: typeof this.origin = null): void {
    this.title = title;
    this.origin = origin;
    this.list = list;
    this.go(list.length > 0 ? 0 : -1);
  }

  clear(): void {
    this.title = () => "";
    this.list = [];
    this.origin = null;
    this.at = -1;
  }

  /** To the next one, or to the previous one; around at the ends. */
  turn(step: 1 | -1): void {
    if (this.list.length > 0) this.go((this.at + step + this.list.length) % this.list.length);
  }

  /** The cursor goes along, unless both cursors hold a selection. */
  private go(at: number): void {
    this.at = at;
    const { current } = this;
    if (current) this.onturn(current);
    if (current && this.cursors.b === null) this.cursors.a = current.from;
  }
}

/** The moments from `from` to `to`, neighbours closer than `least` seconds joined, so that there are never more bands than pixels. */
export function bandsOf(list: readonly Stretch[], from: number, to: number, least: number): Stretch[] {
  const bands: Stretch[] = [];
  for (let at = countWhile(list.length, (before) => list[before]!.to < from); at < list.length && list[at]!.from <= to; at += 1) {
    const one = list[at]!;
    const last = bands[bands.length - 1];
    if (last && one.from - last.to < least) last.to = one.to;
    else bands.push({ ...one });
  }
  return bands;
}
