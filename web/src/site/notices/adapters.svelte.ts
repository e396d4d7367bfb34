// The browser's list of adapters (Web Serial, on a phone WebUSB).
import { accessHere, adaptersBy, type Adapters } from "../usb/access";
import { followAdapters } from "../worker/adapters";
import type { SerialHost } from "../worker/serial";

export const canChoose = (): boolean => accessHere() !== "none";

class Choice {
  /** The list was closed without a choice: perhaps the cable is not in it. */
  cancelled = $state(false);
  /** What was chosen is no serial port that is known here. */
  unknown = $state(false);
}

export const choice = new Choice();

let adapters: Adapters | undefined;
let host: SerialHost | undefined;

/** Follow the adapters from now on, as the worker does since its start. */
export function findAdapters(): void {
  adapters = adaptersBy(accessHere());
  host = followAdapters(adapters);
}

/** Show the browser's list; called in a click. Returns the port as `mikas.browser.web_serial` names it; null: none was chosen. */
export async function choosePort(): Promise<string | null> {
  try {
    const port = await adapters?.requestPort?.();
    choice.cancelled = choice.unknown = false;
    const granted = await host?.ports().promise;
    const it = granted?.find((known) => known.port === port);
    if (!it) return null;
    const kind = it.vid === undefined || it.pid === undefined ? "other" : `${hex(it.vid)}:${hex(it.pid)}`;
    return `${it.scheme}:${kind}${it.nth > 1 ? `:${it.nth}` : ""}`;
  } catch (error) {
    if (!(error instanceof DOMException)) throw error;
    choice.unknown = error.name === "NotSupportedError";
    choice.cancelled = !choice.unknown;
    return null;
  }
}

const hex = (id: number): string => id.toString(16).padStart(4, "0");
