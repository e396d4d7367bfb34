// The passport as last read; kept while another screen is shown, dropped with another ECU.
import { api } from "../../lib/api/api";
import { ApiRequest } from "../../lib/api/request.svelte";
import { ecuKey } from "../../lib/live/capabilities.svelte";
import type { Passport } from "../../lib/api/types";

class PassportStore {
  readonly read = new ApiRequest<Passport>();
  /** The commands are being tried, which takes seconds. */
  probing = $state(false);
  private unit = "";

  async refresh(): Promise<void> {
    const unit = ecuKey();
    if (unit !== this.unit) {
      this.unit = unit;
      this.read.reset();
    }
    const tried = this.read.value?.supported ?? null;
    const passport = await this.read.run(() => api.passport());
    // Keep the tried commands when the passport is read again.
    if (passport && !passport.supported && tried) this.read.value = { ...passport, supported: tried };
  }

  async probe(): Promise<void> {
    this.probing = true;
    try {
      await this.read.run(() => api.probe());
    } finally {
      this.probing = false;
    }
  }
}

export const passports = new PassportStore();
