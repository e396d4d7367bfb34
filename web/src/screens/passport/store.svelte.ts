// The passport as last read; kept while another screen is shown, dropped with another ECU.
import { Resource } from "../../lib/api/resource.svelte";
import type { Passport } from "../../lib/api/types";
import type { Stores } from "../../stores";

export class PassportStore {
  readonly read: Resource<string, Passport> = new Resource({
    of: () => (this.app.live.answers ? this.app.live.unit : null),
    ask: async () => {
      const passport = await this.app.api.passport();
      // Keep the tried commands when the passport is read again.
      return { ...passport, supported: passport.supported ?? this.read.value?.supported ?? null };
    },
  });
  /** The commands are being tried, which takes seconds. */
  probing = $state(false);

  constructor(private readonly app: Pick<Stores, "api" | "live">) {}

  async probe(): Promise<void> {
    this.probing = true;
    await this.read.run(() => this.app.api.probe());
    this.probing = false;
  }
}
