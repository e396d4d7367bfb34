// Which client holds control. `allowed`: this page may change things now, or takes free control with its first change.
import { live } from "../live/live.svelte";

class Control {
  readonly viewOnly = $derived(live.state?.rights === "view");
  readonly holder = $derived(live.state?.controller ?? null);
  readonly mine = $derived(this.holder?.you ?? false);
  readonly elsewhere = $derived(this.holder !== null && !this.mine);
  readonly allowed = $derived(live.state !== null && !this.viewOnly && !this.elsewhere);
}

export const control = new Control();
