// The faults as last read, and the journal; kept while another screen is shown.
import { api } from "../../lib/api/api";
import { ApiRequest } from "../../lib/api/request.svelte";
import { ecuKey } from "../../lib/live/capabilities.svelte";
import type { Faults } from "../../lib/api/types";
import { mergeEntries, type Entry, type RawEntry } from "./journal";

class FaultStore {
  readonly read = new ApiRequest<Faults>();
  readonly journal = new ApiRequest<Entry[]>();
  private unit = "";

  /** Read the faults; those of a previous ECU are dropped. */
  async refresh(): Promise<void> {
    const unit = ecuKey();
    if (unit !== this.unit) {
      this.unit = unit;
      this.read.reset();
    }
    await this.read.run(() => api.faults());
  }

  async refreshJournal(): Promise<void> {
    await this.journal.run(async () => mergeEntries((await api.journal()).entries as RawEntry[]));
  }
}

export const faults = new FaultStore();
