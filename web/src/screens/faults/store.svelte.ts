// The faults as last read, and the journal; kept while another screen is shown.
import { Resource } from "../../lib/api/resource.svelte";
import { ApiRequest } from "../../lib/api/request.svelte";
import type { Faults } from "../../lib/api/types";
import { mergeEntries } from "./journal";
import type { Stores } from "../../stores";

export class FaultStore {
  readonly read = new ApiRequest<Faults>();
  readonly frames = new Resource({
    of: () => this.app.live.unit,
    again: () => this.read.value?.time,
    ask: () => this.app.api.freezeFrames(),
  });
  readonly journal = new Resource({ of: () => true, ask: async () => mergeEntries((await this.app.api.journal()).entries) });
  /** Read when the screen is opened and when another ECU appears. */
  private readonly reading = new Resource({
    of: () => (this.app.live.answers && this.app.control.allowed ? this.app.live.unit : null),
    ask: () => this.refresh(),
  });
  /** A newer reading than the one shown: by another client, by a recording; or this page was opened after the ECU fell silent. */
  private readonly news = new Resource({
    of: () => this.app.live.state?.fault_time ?? null,
    ask: async (time) => void (time !== this.read.value?.time && (await this.takeLast())),
  });
  private unit = "";

  constructor(private readonly app: Pick<Stores, "api" | "control" | "live" | "toasts">) {}

  /** For the screen: what is shown there. */
  need(): void {
    for (const each of [this.reading, this.news, this.frames, this.journal]) each.need();
  }

  /** The number of faults that the screen shows, or will as soon as it has the last reading. */
  get count(): number {
    return this.app.live.state?.fault_count ?? this.read.value?.count ?? 0;
  }

  /** Read the faults; those of a previous ECU are dropped. */
  async refresh(): Promise<void> {
    this.dropPrevious();
    await this.read.run(() => this.app.api.faults());
  }

  /** Get the program's last reading: another client or a recording had them read, or the ECU does not answer. */
  async takeLast(): Promise<void> {
    this.dropPrevious();
    await this.read.run(() => this.app.api.lastFaults());
  }

  private dropPrevious(): void {
    const unit = this.app.live.unit;
    if (unit === this.unit) return;
    this.unit = unit;
    this.read.reset();
  }

  async deleteFrame(id: string): Promise<void> {
    const left = await this.app.toasts.attempt(() => this.app.api.deleteFreezeFrame(id));
    if (left) await this.frames.run(() => Promise.resolve(left));
  }
}
