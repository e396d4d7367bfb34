// The faults as last read, and the journal; kept while another screen is shown.
import { api } from "../../lib/api/api";
import { ApiRequest } from "../../lib/api/request.svelte";
import { live } from "../../lib/live/live.svelte";
import { ecuKey } from "../../lib/live/capabilities.svelte";
import type { Faults, FreezeFrames } from "../../lib/api/types";
import { attempt } from "../../lib/frame/toasts.svelte";
import { mergeEntries, type Entry } from "./journal";

class FaultStore {
  readonly read = new ApiRequest<Faults>();
  readonly frames = new ApiRequest<FreezeFrames>();
  readonly journal = new ApiRequest<Entry[]>();
  private unit = "";

  /** The number of faults that the screen shows, or will as soon as it has the last reading. */
  get count(): number {
    return live.state?.fault_count ?? this.read.value?.count ?? 0;
  }

  /** Read the faults; those of a previous ECU are dropped. */
  async refresh(): Promise<void> {
    this.dropPrevious();
    await this.read.run(() => api.faults());
  }

  /** Get the program's last reading: another client or a recording had them read, or the ECU does not answer. */
  async takeLast(): Promise<void> {
    this.dropPrevious();
    await this.read.run(() => api.lastFaults());
  }

  private dropPrevious(): void {
    const unit = ecuKey();
    if (unit === this.unit) return;
    this.unit = unit;
    this.read.reset();
  }

  async refreshFrames(): Promise<void> {
    await this.frames.run(() => api.freezeFrames());
  }

  async deleteFrame(id: string): Promise<void> {
    if (await attempt(() => api.deleteFreezeFrame(id))) await this.refreshFrames();
  }

  async refreshJournal(): Promise<void> {
    await this.journal.run(async () => mergeEntries((await api.journal()).entries));
  }
}

export const faults = new FaultStore();
