// The passport as last read: kept while one looks at another screen, forgotten with another unit.
import { api } from "../../lib/api/api";
import { ApiRequest } from "../../lib/api/request.svelte";
import { ecuKey } from "../../lib/live/capabilities.svelte";
import type { Passport } from "../../lib/api/types";

class PassportStore {
  readonly read = new ApiRequest<Passport>();
  /** The commands are being tried: seconds, not milliseconds. */
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
    // What was tried stays on the screen: reading the passport again untries nothing.
    if (passport && !passport.supported && tried)
      this.read.value = { ...passport, supported: tried };
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
