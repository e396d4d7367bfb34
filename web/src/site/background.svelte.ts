// What goes on beside the screens as long as the page is open.
import type { Stores } from "../stores";
import { t } from "./notices/messages";
import { interrupted } from "./interrupted";
import { LowBattery } from "./lowBattery";
import { storage } from "./notices/storage.svelte";
import { updates } from "./offline/updates.svelte";
import type { Program } from "./program/program";
import { watch } from "../lib/platform/watch.svelte";

/** The offer of a new version: its code, and for how many ms it is shown; it stays on the Connection screen. */
const OFFER = "NewVersion";
const OFFER_MS = 60_000;
/** ms of sampling; then the computer has time to start the reader. */
const SETTLED_MS = 5000;

export function background(program: Program, stores: Stores): void {
  const { battery, live, toasts } = stores;
  const lowBattery = new LowBattery(stores);
  $effect.root(() => {
    storage.watch(stores);

    const recording = $derived(live.state?.recording?.file ?? null);
    const catalog = $derived(live.state?.catalog ?? null);
    $effect(() => program.follow({ recording, catalog }));

    // Who can't keep the recording has nothing to come back to.
    $effect(() => void (live.state && storage.kept && interrupted.follow(live.state, Date.now())));

    // Again with each state: a recording that could not be closed is tried once more.
    watch(
      () => live.state && battery.left,
      () => void lowBattery.follow(battery.left),
    );

    const line = $derived(live.state?.line);
    $effect(() => void (program.lineIsFree = line === "off"));
    $effect(() => {
      if (line !== "sampling") return;
      const timer = setTimeout(() => program.prepareReader(), SETTLED_MS);
      return () => clearTimeout(timer);
    });

    const offer = { code: OFFER, duration: OFFER_MS, action: { text: () => t("use"), run: () => updates.use() } };
    watch(
      () => updates.offered,
      (offered) => (offered ? toasts.success(() => t("new_ready"), offer) : toasts.dismiss(new Set([OFFER]))),
    );
  });
}
