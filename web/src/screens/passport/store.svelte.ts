// The passport as last read; kept while another screen is shown, dropped with another ECU.
import { ApiRequest } from "../../lib/api/request.svelte";
import type { Passport } from "../../lib/api/types";
import type { ApiClient } from "../../lib/api/api";
import type { Live } from "../../lib/live/live.svelte";

export class PassportStore {
  readonly read = new ApiRequest<Passport>();
  /** The commands are being tried, which takes seconds. */
  probing = $state(false);
  private unit = "";

  constructor(
    private readonly api: ApiClient,
    private readonly live: Live,
  ) {}

  async refresh(): Promise<void> {
    const unit = this.live.unit;
    if (unit !== this.unit) {
      this.unit = unit;
      this.read.reset();
    }
    const tried = this.read.value?.supported ?? null;
    const passport = await this.read.run(() => this.api.passport());
    // Keep the tried commands when the passport is read again.
    if (passport && !passport.supported && tried) this.read.value = { ...passport, supported: tried };
  }

  async probe(): Promise<void> {
    this.probing = true;
    try {
      await this.read.run(() => this.api.probe());
    } finally {
      this.probing = false;
    }
  }
}
