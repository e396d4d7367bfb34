// What actions have done: their sound and voice on this page, and a message for each, or for what has failed.
import { localized } from "../i18n";
import type { LineEvent } from "../api/types";
import type { Stores } from "../../stores";

/** s: an older event was news for an earlier page. */
const RECENT = 10;

/** Returns a function to be called with all events after each change. Events are in the order of their times, not of their coming. */
export function actionTeller({ pageActions, live, toasts }: Pick<Stores, "pageActions" | "live" | "toasts">) {
  let told = new Set<string>();
  return (events: readonly LineEvent[]): void => {
    const recent = new Set<string>();
    for (const event of events) {
      if (event.kind !== "action" || live.now() - event.time > RECENT) continue;
      const key = JSON.stringify(event);
      recent.add(key);
      if (told.has(key)) continue;
      const { failed, sound, speak, text } = event;
      if (failed) toasts.error(() => localized(text));
      else toasts.success(() => localized(text));
      if (sound) pageActions.ring();
      if (speak) pageActions.say(speak);
    }
    told = recent;
  };
}
