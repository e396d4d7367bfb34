// The browser's list of adapters (Web Serial).

/** What is needed of `navigator.serial`, which TypeScript does not know. */
interface SerialPort {
  getInfo(): { usbVendorId?: number; usbProductId?: number };
}
interface Serial {
  requestPort(): Promise<SerialPort>;
}

const serial = (): Serial | undefined => (globalThis.navigator as { serial?: Serial } | undefined)?.serial;

export const canChoose = (): boolean => serial() !== undefined;

class Choice {
  /** The list was closed without a choice: perhaps the cable is not in it. */
  cancelled = $state(false);
}

export const choice = new Choice();

/** Show the browser's list; called in a click. Returns the port as `mikas.browser.web_serial` names the first one of its kind; null: none was chosen. */
export async function choosePort(): Promise<string | null> {
  const adapters = serial();
  if (!adapters) return null;
  try {
    const { usbVendorId, usbProductId } = (await adapters.requestPort()).getInfo();
    choice.cancelled = false;
    return usbVendorId === undefined || usbProductId === undefined ? "webserial:other" : `webserial:${hex(usbVendorId)}:${hex(usbProductId)}`;
  } catch (error) {
    if (!(error instanceof DOMException)) throw error;
    choice.cancelled = true;
    return null;
  }
}

const hex = (id: number): string => id.toString(16).padStart(4, "0");
