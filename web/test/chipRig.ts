// A driver of a chip over a scripted device: what its start asks for, and the rates that it makes.
import { expect } from "vitest";
import { channelOf } from "../src/site/usb/channel";
import type { Chip, Line } from "../src/site/usb/chips/chip";
import { driverOf } from "../src/site/usb/identify";
import type { ScriptedUsb } from "./scriptedUsb";

export const EIGHT_N_ONE: Line = { baudRate: 9600, dataBits: 8, parity: "none", stopBits: 1 };
export const SEVEN_E_TWO: Line = { baudRate: 9600, dataBits: 7, parity: "even", stopBits: 2 };
export const THE_RATES = [4800, 9600, 10400, 115200];

export function chipOf(device: ScriptedUsb): Chip {
  const channel = channelOf(device.configurations[0])!;
  return driverOf(device, channel, async (bytes) => void device.written.push([...bytes]));
}

/** The requests and the rate of a start. */
export async function started(device: ScriptedUsb, line: Partial<Line> = {}): Promise<[string[], number]> {
  const rate = await chipOf(device).start({ ...EIGHT_N_ONE, ...line });
  return [device.asked, rate];
}

/** The requests of a start that begin so, with each of the rates, and the rates that come of them. */
export async function atTheRates(make: () => ScriptedUsb, begins: string): Promise<[string[], number[]]> {
  const [requests, rates]: [string[], number[]] = [[], []];
  for (const baudRate of THE_RATES) {
    const [asked, rate] = await started(make(), { baudRate });
    requests.push(...asked.filter((it) => it.startsWith(begins)));
    rates.push(Math.round(rate));
  }
  return [requests, rates];
}

export async function asksFor(device: ScriptedUsb, what: (chip: Chip) => Promise<void>): Promise<string[]> {
  const chip = chipOf(device);
  await chip.start(EIGHT_N_ONE);
  device.asked = [];
  await what(chip);
  return device.asked;
}

export const refuses = (device: ScriptedUsb, line: Partial<Line> = {}) => expect(started(device, line)).rejects;
export const unsupported = { name: "NotSupportedError" };
