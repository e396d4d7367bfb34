// Web Serial (https://wicg.github.io/serial/), as far as it is used: TypeScript does not describe it.

export interface SerialOptions {
  baudRate: number;
  dataBits?: 5 | 6 | 7 | 8;
  parity?: "none" | "odd" | "even" | "mark" | "space";
  stopBits?: 1 | 2;
  bufferSize?: number;
}

export interface SerialPort extends EventTarget {
  readonly readable: ReadableStream<Uint8Array> | null;
  readonly writable: WritableStream<Uint8Array> | null;
  /** Missing in older browsers. */
  readonly connected?: boolean;
  /** The scheme of the port's name; missing: it is the browser's own, `webserial`. */
  readonly scheme?: string;
  /** Of a port with a driver of this page (`../usb/`): ms that `open` may take; bits a second that the chip makes; s by which bytes come late;
   * the device's serial number, empty if it has none. */
  readonly patience?: number;
  readonly rate?: number;
  readonly granularity?: number;
  readonly serialNumber?: string;
  getInfo(): { usbVendorId?: number; usbProductId?: number };
  open(options: SerialOptions): Promise<void>;
  setSignals(signals: { dataTerminalReady?: boolean; requestToSend?: boolean; break?: boolean }): Promise<void>;
  close(): Promise<void>;
}

export interface Serial extends EventTarget {
  getPorts(): Promise<SerialPort[]>;
}

declare global {
  interface Navigator {
    /** In a page; a worker can't ask for a port. */
    readonly serial?: Serial & { requestPort(): Promise<SerialPort> };
  }
}
