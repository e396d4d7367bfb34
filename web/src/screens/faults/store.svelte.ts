// The stored faults as last read, and the journal: kept while one looks at another screen.
import { api } from "../../lib/api/api";
import { Asked } from "../../lib/api/request.svelte";
import { unitKey } from "../../lib/live/capabilities.svelte";
import type { Faults } from "../../lib/api/types";
import { folded, type Entry, type RawEntry } from "./journal";

class FaultStore {
  readonly read = new Asked<Faults>();
  readonly journal = new Asked<Entry[]>();
  private unit = "";

  /** Asks the unit; what was read of another one goes. */
  async refresh(): Promise<void> {
    const unit = unitKey();
    if (unit !== this.unit) {
      this.unit = unit;
      this.read.forget();
    }
    await this.read.ask(() => api.faults());
  }

  async refreshJournal(): Promise<void> {
    await this.journal.ask(async () => folded((await api.journal()).entries as RawEntry[]));
  }
}

export const faults = new FaultStore();
