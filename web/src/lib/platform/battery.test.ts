import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { State } from "../api/types";
import { served } from "./host";
import { Stores } from "../../stores";

class Manager extends EventTarget {
  level = 0.64;
  charging = false;
  becomes(change: Partial<Pick<Manager, "level" | "charging">>, event: string) {
    Object.assign(this, change);
    this.dispatchEvent(new Event(event));
  }
}

let manager: Manager;

beforeEach(() => {
  manager = new Manager();
  vi.stubGlobal("navigator", { getBattery: () => Promise.resolve(manager) });
});
afterEach(() => void vi.unstubAllGlobals());

const line = (line: string, port: string | null = "webusb:1a86:7523") => ({ line, port }) as State;

async function phone(feedsAdapters = true) {
  const { battery, live } = new Stores({ ...served, feedsAdapters });
  await battery.follow();
  return { battery, live };
}

it("is shown while the phone feeds the cable, and is not charged", async () => {
  const { battery, live } = await phone();
  expect(battery.left).toBeNull();
  live.state = line("sampling");
  expect(battery.left).toBe(64);
  manager.becomes({ level: 0.199 }, "levelchange");
  expect(battery.left).toBe(20);
  manager.becomes({ charging: true }, "chargingchange"); // without a wire
  expect(battery.left).toBeNull();
  manager.becomes({ charging: false }, "chargingchange");
  live.state = line("no-port"); // pulled out: now it can be charged
  expect(battery.left).toBeNull();
  live.state = line("sampling", "sim:");
  expect(battery.left).toBeNull();
});

it("a computer's is its own affair, and a browser that keeps it to itself is no trouble", async () => {
  const computer = await phone(false);
  computer.live.state = line("sampling");
  expect(computer.battery.left).toBeNull();
  for (const getBattery of [undefined, () => Promise.reject(new DOMException("no", "NotAllowedError"))]) {
    vi.stubGlobal("navigator", { getBattery });
    const { battery, live } = await phone();
    live.state = line("sampling");
    expect(battery.left).toBeNull();
  }
});
