// A port over WebUSB as the tests of it use it, on simulated time.
import { vi } from "vitest";
import { UsbSerialPort } from "../src/site/usb/usbSerialPort";
import type { ScriptedUsb } from "./scriptedUsb";

export const OPTIONS = { baudRate: 9600, bufferSize: 65536 };
export async function opened(device: ScriptedUsb): Promise<UsbSerialPort> {
  const port = new UsbSerialPort(device);
  await port.open(OPTIONS);
  return port;
}

/** All that comes from the port, as `serial.ts` reads it: bytes, and the names of errors, until there is no stream any more. */
export function heard(port: UsbSerialPort): (number | string)[] {
  const all: (number | string)[] = [];
  async function listen(): Promise<void> {
    for (let stream = port.readable; stream; stream = port.readable) {
      const reader = stream.getReader();
      try {
        for (let read = await reader.read(); !read.done; read = await reader.read()) all.push(...read.value);
        all.push("end");
        return;
      } catch (error) {
        all.push((error as Error).name);
      } finally {
        reader.releaseLock();
      }
    }
    all.push("no stream");
  }
  void listen();
  return all;
}

/** After all that streams, transfers and the script have to do. */
export const settled = () => vi.advanceTimersByTimeAsync(1);

export async function write(port: UsbSerialPort, ...bytes: number[]): Promise<void> {
  const writer = port.writable!.getWriter();
  try {
    await writer.write(new Uint8Array(bytes));
  } finally {
    writer.releaseLock();
  }
}
