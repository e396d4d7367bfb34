// On a phone: a cable that is plugged in, and that the browser has allowed before, is connected to without a touch; once, until a person does something
// else with the connection.
import { untrack } from "svelte";
import { bestGuess } from "../screens/connection/diagnosis/verdict";
import type { Stores } from "../stores";

export function connectByItself({ connection, control, host, live }: Stores): void {
  if (!host.feedsAdapters) return;
  let over = $state(false);
  $effect.root(() => {
    $effect(() => {
      if (live.state !== null && live.state.line !== "off") over = true;
    });
    $effect(() => {
      if (!over) connection.ports.need();
    });
    $effect(() => {
      const best = bestGuess(connection.ports.value ?? []);
      if (over || best === null || connection.choosing || connection.wanted !== null || !control.allowed) return;
      over = true;
      untrack(() => void connection.begin(best.url));
    });
  });
}
