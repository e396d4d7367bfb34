// The `Serial` of Web Serial over WebUSB: the granted devices that are serial ports.
import type { Serial, SerialPort } from "../worker/webSerial";
import { familyOf, FILTERS } from "./identify";
import { UsbSerialPort } from "./usbSerialPort";
import type { Usb, UsbDevice } from "./webUsb";

export class UsbSerial extends EventTarget implements Serial {
  private readonly known = new WeakMap<UsbDevice, UsbSerialPort>();

  constructor(private readonly usb: Usb) {
    super();
    usb.addEventListener("connect", (event) => {
      const device = this.deviceOf(event);
      if (!device) return;
      this.known.delete(device); // a browser may have the same object for it as before
      this.dispatchEvent(new Event("connect"));
    });
    usb.addEventListener("disconnect", (event) => {
      const device = this.deviceOf(event);
      if (!device) return;
      // It stays known, and lost: the browser's list may still have it.
      this.portOf(device).unplug();
      this.dispatchEvent(new Event("disconnect"));
    });
  }

  async getPorts(): Promise<SerialPort[]> {
    const devices = await this.usb.getDevices();
    return devices.filter((device) => familyOf(device) !== null).map((device) => this.portOf(device));
  }

  /** Raises NotFoundError if none was chosen, NotSupportedError if that is no serial port. */
  async requestPort(): Promise<SerialPort> {
    if (!this.usb.requestDevice) throw new DOMException("Only a page can ask.", "NotSupportedError");
    const device = await this.usb.requestDevice({ filters: FILTERS });
    if (familyOf(device) === null) throw new DOMException("The device is no serial port that is known here.", "NotSupportedError");
    return this.portOf(device);
  }

  private portOf(device: UsbDevice): UsbSerialPort {
    const known = this.known.get(device);
    if (known) return known;
    const port = new UsbSerialPort(device);
    this.known.set(device, port);
    return port;
  }

  private deviceOf(event: Event): UsbDevice | null {
    // eslint-disable-next-line @typescript-eslint/consistent-type-assertions -- a USBConnectionEvent, which TypeScript does not describe
    const { device } = event as Event & { device?: UsbDevice };
    return device && familyOf(device) !== null ? device : null;
  }
}
