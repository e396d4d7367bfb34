// The browser's list of adapters (Web Serial).
import { followAdapters } from "../worker/adapters";
import type { SerialHost } from "../worker/serial";

export const canChoose = (): boolean => globalThis.navigator?.serial !== undefined;

class Choice {
  /** The list was closed without a choice: perhaps the cable is not in it. */
  cancelled = $state(false);
}

export const choice = new Choice();

let adapters: SerialHost | undefined;

/** Follow the adapters from now on, as the worker does since its start. */
export function findAdapters(): void {
  adapters = followAdapters(globalThis.navigator?.serial);
}

/** Show the browser's list; called in a click. Returns the port as `mikas.browser.web_serial` names it; null: none was chosen. */
export async function choosePort(): Promise<string | null> {
  try {
    const port = await navigator.serial?.requestPort();
    choice.cancelled = false;
    const granted = await adapters?.ports().promise;
    const it = granted?.find((known) => known.port === port);
    if (!it) return null;
    const kind = it.vid === undefined || it.pid === undefined ? "other" : `${hex(it.vid)}:${hex(it.pid)}`;
    return `webserial:${kind}${it.nth > 1 ? `:${it.nth}` : ""}`;
  } catch (error) {
    if (!(error instanceof DOMException)) throw error;
    choice.cancelled = true;
    return null;
  }
}

const hex = (id: number): string => id.toString(16).padStart(4, "0");
