// Search in what the chart shows: the server computes the condition; the moments are marked in the chart. Conditions are kept by the server.
import { ApiRequest } from "../../../../lib/api/request.svelte";
import { number } from "../../../../lib/i18n";
import type { Found, KeptSearch } from "../../../../lib/api/types";
import { t } from "./messages";
import type { Stores } from "../../../../stores";

export class Find {
  open = $state(false);
  expression = $state("");
  /** Its error says why the condition is none. */
  readonly search = new ApiRequest<Found>();
  /** The condition that holds at no moment. */
  nowhere = $state("");
  kept = $state.raw<readonly KeptSearch[]>([]);

  constructor(private readonly app: Pick<Stores, "api" | "catalog" | "player" | "moments" | "toasts">) {}

  /** For the sheet that opens: the kept conditions, and nothing of what was found in another source. */
  async begin(): Promise<void> {
    this.search.error = null;
    this.nowhere = "";
    await this.load();
  }

  private async load(): Promise<boolean> {
    const list = await this.app.toasts.attempt(() => this.app.api.searches());
    if (list) this.kept = list.searches;
    return list !== undefined;
  }

  /** Find and mark; the sheet closes if there is a moment. */
  async run(expression: string): Promise<void> {
    if (this.search.busy) return;
    const condition = (this.expression = expression.trim());
    this.search.error = null;
    this.nowhere = "";
    if (!condition) return;
    const { catalog, moments, player } = this.app;
    const recording = player.shown?.id ?? null;
    const found = await this.search.run(() => this.app.api.find(recording, condition));
    // Another source is shown meanwhile: its moments are others.
    if (!found || (player.shown?.id ?? null) !== recording) return;
    if (found.hits.length === 0) {
      moments.clear();
      this.nowhere = condition;
      return;
    }
    moments.mark(
      () => titleOf(condition, found, (name) => catalog.nameOf(name)),
      found.hits.map(({ begin, end }) => ({ from: begin, to: end })),
    );
    this.open = false;
  }

  isKept(expression: string): boolean {
    return this.kept.some((kept) => kept.expression === expression.trim());
  }

  async keep(expression: string): Promise<void> {
    const added = { name: "", expression: expression.trim() };
    await this.change((before) => [...before.filter((kept) => kept.expression !== added.expression), added]);
  }

  async drop(expression: string): Promise<void> {
    await this.change((before) => before.filter((kept) => kept.expression !== expression));
  }

  /** The whole list is saved, so it starts from what is kept now: another page may have added to it, or it has not been loaded. */
  private async change(change: (before: readonly KeptSearch[]) => KeptSearch[]): Promise<void> {
    if (!(await this.load())) return;
    const list = await this.app.toasts.attempt(() => this.app.api.saveSearches(change(this.kept)));
    if (list) this.kept = list.searches;
  }
}

/** The condition, the extreme of what it compares, and whether more were found than are marked. */
export function titleOf(
  expression: string,
  found: Pick<Found, "hits" | "count" | "peak_of" | "lowest">,
  nameOf: (channel: string) => string = (channel) => channel,
): string {
  const peaks = found.hits.map(({ peak }) => peak).filter((peak) => peak !== null);
  let title = expression;
  if (found.peak_of && peaks.length > 0) {
    const peak = peaks.reduce((one, other) => (found.lowest ? Math.min(one, other) : Math.max(one, other)));
    const fields = { expression, what: nameOf(found.peak_of), peak: number(peak, Number.isInteger(peak) ? 0 : 2) };
    title = t(found.lowest ? "peakLow" : "peakHigh", fields);
  }
  return found.count > found.hits.length ? t("first", { title, n: number(found.hits.length), count: number(found.count) }) : title;
}
