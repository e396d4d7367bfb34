// Web Serial (https://wicg.github.io/serial/), as far as it is used: TypeScript does not describe it.

export interface SerialPort extends EventTarget {
  readonly readable: ReadableStream<Uint8Array> | null;
  readonly writable: WritableStream<Uint8Array> | null;
  /** Missing in older browsers. */
  readonly connected?: boolean;
  getInfo(): { usbVendorId?: number; usbProductId?: number };
  open(options: { baudRate: number; bufferSize?: number }): Promise<void>;
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
