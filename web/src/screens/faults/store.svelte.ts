// The faults as last read, and the journal; kept while another screen is shown.
import { ApiRequest } from "../../lib/api/request.svelte";
import type { Faults, FreezeFrames } from "../../lib/api/types";
import { mergeEntries, type Entry } from "./journal";
import type { ApiClient } from "../../lib/api/api";
import type { Live } from "../../lib/live/live.svelte";
import type { Toasts } from "../../lib/frame/toasts.svelte";

export class FaultStore {
  readonly read = new ApiRequest<Faults>();
  readonly frames = new ApiRequest<FreezeFrames>();
  readonly journal = new ApiRequest<Entry[]>();
  private unit = "";

  constructor(
    private readonly api: ApiClient,
    private readonly live: Live,
    private readonly toasts: Toasts,
  ) {}

  /** The number of faults that the screen shows, or will as soon as it has the last reading. */
  get count(): number {
    return this.live.state?.fault_count ?? this.read.value?.count ?? 0;
  }

  /** Read the faults; those of a previous ECU are dropped. */
  async refresh(): Promise<void> {
    this.dropPrevious();
    await this.read.run(() => this.api.faults());
  }

  /** Get the program's last reading: another client or a recording had them read, or the ECU does not answer. */
  async takeLast(): Promise<void> {
    this.dropPrevious();
    await this.read.run(() => this.api.lastFaults());
  }

  private dropPrevious(): void {
    const unit = this.live.unit;
    if (unit === this.unit) return;
    this.unit = unit;
    this.read.reset();
  }

  async refreshFrames(): Promise<void> {
    await this.frames.run(() => this.api.freezeFrames());
  }

  async deleteFrame(id: string): Promise<void> {
    if (await this.toasts.attempt(() => this.api.deleteFreezeFrame(id))) await this.refreshFrames();
  }

  async refreshJournal(): Promise<void> {
    await this.journal.run(async () => mergeEntries((await this.api.journal()).entries));
  }
}
