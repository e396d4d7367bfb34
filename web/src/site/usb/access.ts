// How this browser reaches a cable. On a computer that is Web Serial: the system has a driver for the chip, and on Windows WebUSB needs another one.
// On Android it is WebUSB, with the drivers of this page: there Web Serial is missing, or lists Bluetooth alone, unless both Android and the
// kernel of the phone are among the newest.
import { within } from "../within";
import type { Access } from "../program/messages";
import type { Serial, SerialPort } from "../worker/webSerial";
import { UsbSerial } from "./usbSerial";

/** The adapters that the page may use, and the browser's list, where it can be shown. */
export interface Adapters extends Serial {
  requestPort?(): Promise<SerialPort>;
}

/** ms in which a phone's Web Serial lists what it has. */
const PATIENCE = 500;

/** How the adapters are reached here; asked in a page, for a worker sees less. */
export const accessHere = (): Access => accessOf(globalThis.navigator, isTouched());

/** `touched`: a finger is what points here. */
export function accessOf({ serial, usb, userAgent }: Pick<Navigator, "serial" | "usb" | "userAgent">, touched: boolean): Access {
  if (isPhone(userAgent, touched) && usb) return "usb";
  return serial ? "serial" : "none";
}

/** Whether this is a phone. One that was asked for a page as on a computer says that it has Linux on a PC. */
const isPhone = (userAgent: string, touched: boolean): boolean =>
  userAgent.includes("Android") || (touched && userAgent.includes("X11; Linux"));

/** GB of a device, as browsers round it, up to which a second program in memory is one too many. */
const FEW = 2;

/** Whether memory is scarce here. A phone ends what is in the background by its size, whatever it has; a computer swaps. */
export const memoryIsScarce = (
  { userAgent, deviceMemory }: { userAgent: string; deviceMemory?: number } = globalThis.navigator,
  touched = isTouched(),
): boolean => isPhone(userAgent, touched) || (deviceMemory ?? Infinity) <= FEW;

const isTouched = (): boolean => globalThis.matchMedia?.("(pointer: coarse)").matches ?? false;

/** The adapters by this way; undefined: there are none. */
export function adaptersBy(access: Access): Adapters | undefined {
  const { serial, usb } = globalThis.navigator ?? {};
  if (access === "usb" && usb) return new PhoneSerial(new UsbSerial(usb), serial);
  return access === "serial" ? serial : undefined;
}

/** The ports of a phone: those of its Web Serial, should it list any, and those over WebUSB that are not among them. */
class PhoneSerial extends EventTarget implements Adapters {
  constructor(
    private readonly usb: UsbSerial,
    private readonly serial: Serial | undefined,
  ) {
    super();
    for (const change of ["connect", "disconnect"]) {
      for (const it of [usb, serial]) it?.addEventListener(change, () => this.dispatchEvent(new Event(change)));
    }
  }

  async getPorts(): Promise<SerialPort[]> {
    const own = await within(PATIENCE, this.serial?.getPorts() ?? Promise.resolve([])).catch(() => []);
    const listed = new Set(own.map(kindOf));
    const others = await this.usb.getPorts();
    return [...own, ...others.filter((port) => !listed.has(kindOf(port)))];
  }

  requestPort(): Promise<SerialPort> {
    return this.usb.requestPort();
  }
}

const kindOf = (port: SerialPort): string => {
  const { usbVendorId, usbProductId } = port.getInfo();
  return `${usbVendorId}:${usbProductId}`;
};
