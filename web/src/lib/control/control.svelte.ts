// Which client holds control. `allowed`: this page may change things now, or takes free control with its first change.
import type { Live } from "../live/live.svelte";

export class Control {
  readonly viewOnly = $derived.by(() => this.live.state?.rights === "view");
  readonly holder = $derived.by(() => this.live.state?.controller ?? null);
  readonly mine = $derived(this.holder?.you ?? false);
  readonly elsewhere = $derived(this.holder !== null && !this.mine);
  readonly allowed = $derived.by(() => this.live.state !== null && !this.viewOnly && !this.elsewhere);

  constructor(private readonly live: Live) {}
}
