// An adjustment of the idle CO: the meter's figures so far, what to do next, and each write as a change that a person confirms. It stays while another
// screen is shown.
import { ApiRequest } from "../../../lib/api/request.svelte";
import { PendingChange } from "../../../lib/api/pendingChange.svelte";
import type { CoMeter, CoStep } from "../../../lib/api/types";
import type { Stores } from "../../../stores";

export interface Adjustment {
  meter: CoMeter;
  target: number;
  within: number;
  /** The byte at its begin, in hex. */
  found: string;
  /** The unit that it is of. */
  unit: string;
}

export class CoStore {
  adjustment = $state.raw<Adjustment | null>(null);
  /** Those that belong to what was written since. */
  figures = $state.raw<readonly number[]>([]);
  /** What the last figure leads to; null: the next one is waited for. */
  due = $state.raw<CoStep | null>(null);
  change = $state.raw<PendingChange | null>(null);
  /** The byte that RCOD had after the last write. */
  raw = $state<string | null>(null);
  readonly step = new ApiRequest<CoStep>();
  /** What a person has entered so far: a line that is lost for a moment takes nothing of it away. */
  readonly entered = $state<{ meter: CoMeter; target: string; within: string; figure: string }>({
    ...{ meter: "co", target: "", within: "", figure: "" },
  });

  constructor(private readonly app: Pick<Stores, "api">) {}

  begin(adjustment: Adjustment): void {
    this.adjustment = adjustment;
    [this.figures, this.due, this.change, this.raw] = [[], null, null, adjustment.found];
    this.entered.figure = "";
    this.step.reset();
  }

  forget(): void {
    this.adjustment = this.due = this.change = null;
    this.entered.figure = "";
  }

  /** Ask what to do with a figure of the meter. One that does not count, as the engine is not at warm idle, is asked for again. */
  async measured(figure: number): Promise<void> {
    const { adjustment } = this;
    if (!adjustment) return;
    const { meter, target, within, found } = adjustment;
    const figures = [...this.figures, figure];
    const due = await this.step.run(() => this.app.api.coStep({ meter, target, within, found, figures }));
    if (!due || this.adjustment !== adjustment) return;
    this.due = due;
    if (due.problems.length > 0) return;
    this.figures = figures;
    if (due.outcome === "write") await this.propose(due.next.raw);
  }

  /** The step is not made: the figure is given again later. */
  decline(): void {
    this.figures = this.figures.slice(0, -1);
    this.due = this.change = null;
  }

  async write(): Promise<void> {
    if (await this.confirmed()) this.due = null;
  }

  /** With one touch: the value that was found is proposed and confirmed at once. */
  async putBack(): Promise<void> {
    if (!this.adjustment) return;
    await this.propose(this.adjustment.found);
    if (!this.change?.proposal.error && (await this.confirmed())) [this.figures, this.due] = [[], null];
  }

  private async propose(raw: string): Promise<void> {
    this.change = new PendingChange(this.app.api, { kind: "write_parameter", name: "RCOD", raw });
    await this.change.prepare();
  }

  private async confirmed(): Promise<boolean> {
    const { change } = this;
    const after = (await change?.confirm())?.after;
    if (change !== this.change || !after || typeof after !== "object" || !("raw" in after)) return false;
    this.raw = String(after.raw);
    this.change = null;
    return true;
  }
}
