// WebUSB (https://wicg.github.io/webusb/), as far as it is used: TypeScript does not describe it.

export interface UsbEndpoint {
  readonly endpointNumber: number;
  readonly direction: "in" | "out";
  readonly type: "bulk" | "interrupt" | "isochronous";
  readonly packetSize: number;
}

export interface UsbInterface {
  readonly interfaceNumber: number;
  readonly alternate: { readonly interfaceClass: number; readonly interfaceSubclass: number; readonly endpoints: readonly UsbEndpoint[] };
}

export interface UsbConfiguration {
  readonly configurationValue: number;
  readonly interfaces: readonly UsbInterface[];
}

export interface UsbRequest {
  requestType: "standard" | "class" | "vendor";
  recipient: "device" | "interface" | "endpoint" | "other";
  request: number;
  value: number;
  index: number;
}

/** A promise of a transfer is kept with these as well: a stall or a babble is no rejection. */
export type UsbStatus = "ok" | "stall" | "babble";

export interface UsbInResult {
  readonly status?: UsbStatus;
  readonly data?: DataView;
}

export interface UsbOutResult {
  readonly status?: UsbStatus;
  readonly bytesWritten: number;
}

export interface UsbDevice {
  readonly vendorId: number;
  readonly productId: number;
  readonly usbVersionMajor: number;
  readonly usbVersionMinor: number;
  /** bcdDevice 0x0264 is 2, 6, 4. */
  readonly deviceVersionMajor: number;
  readonly deviceVersionMinor: number;
  readonly deviceVersionSubminor: number;
  readonly deviceClass: number;
  readonly serialNumber?: string | null;
  readonly opened: boolean;
  readonly configuration?: UsbConfiguration | null;
  readonly configurations: readonly UsbConfiguration[];
  open(): Promise<void>;
  close(): Promise<void>;
  selectConfiguration(value: number): Promise<void>;
  claimInterface(number: number): Promise<void>;
  controlTransferIn(request: UsbRequest, length: number): Promise<UsbInResult>;
  controlTransferOut(request: UsbRequest, data?: BufferSource): Promise<UsbOutResult>;
  transferIn(endpoint: number, length: number): Promise<UsbInResult>;
  transferOut(endpoint: number, data: BufferSource): Promise<UsbOutResult>;
  clearHalt(direction: "in" | "out", endpoint: number): Promise<void>;
}

export interface UsbFilter {
  vendorId?: number;
  productId?: number;
  classCode?: number;
  subclassCode?: number;
}

/** `connect` and `disconnect` come here, with the device. */
export interface Usb extends EventTarget {
  getDevices(): Promise<UsbDevice[]>;
  /** In a page; a worker can't ask for a device. */
  requestDevice?(options: { filters: readonly UsbFilter[] }): Promise<UsbDevice>;
}

declare global {
  interface Navigator {
    readonly usb?: Usb;
  }
}
