import { readFileSync } from "node:fs";
import { expect, it, vi } from "vitest";
import { cdcAcm, ch340, cp210x, ftdi, pl2303, ScriptedUsb } from "../../../test/scriptedUsb";
import { familyOf, FILTERS } from "./identify";
import { UsbSerial } from "./usbSerial";

class FakeUsb extends EventTarget {
  requestDevice = vi.fn();
  constructor(public devices: ScriptedUsb[]) {
    super();
  }
  getDevices = async () => [...this.devices];

  change(kind: "connect" | "disconnect", device: ScriptedUsb): void {
    this.dispatchEvent(Object.assign(new Event(kind), { device }));
  }
}

const keyboard = () => new ScriptedUsb(0x046d, 0xc31c, [{ configurationValue: 1, interfaces: [] }], 0x6402);

it("the granted devices that are serial ports are its ports, always the same", async () => {
  const serial = new UsbSerial(new FakeUsb([ftdi(), keyboard(), ch340()]));
  const ports = await serial.getPorts();
  expect(ports.map((port) => port.getInfo())).toEqual([
    { usbVendorId: 0x0403, usbProductId: 0x6001 },
    { usbVendorId: 0x1a86, usbProductId: 0x7523 },
  ]);
  expect(await serial.getPorts()).toEqual(ports);
});

it("the chosen device is a port, and another kind of device is refused", async () => {
  const device = ftdi();
  const usb = new FakeUsb([device]);
  const serial = new UsbSerial(usb);
  usb.requestDevice.mockResolvedValueOnce(device).mockResolvedValueOnce(keyboard());
  expect(await serial.requestPort()).toBe((await serial.getPorts())[0]);
  expect(usb.requestDevice).toHaveBeenCalledWith({ filters: FILTERS });
  await expect(serial.requestPort()).rejects.toMatchObject({ name: "NotSupportedError" });
});

it("a device that comes or goes is an event, and one that goes is lost", async () => {
  const device = ftdi();
  const usb = new FakeUsb([device]);
  const serial = new UsbSerial(usb);
  const seen: string[] = [];
  for (const kind of ["connect", "disconnect"]) serial.addEventListener(kind, () => seen.push(kind));
  const [port] = await serial.getPorts();
  port!.addEventListener("disconnect", () => seen.push("lost"));
  usb.change("disconnect", device);
  usb.change("disconnect", keyboard());
  expect([seen, port!.connected]).toEqual([["lost", "disconnect"], false]);
  expect((await serial.getPorts()).map(({ connected }) => connected)).toEqual([false]);
  usb.change("connect", device);
  expect((await serial.getPorts()).map(({ connected }) => connected)).toEqual([true]);
  usb.devices = [ftdi()];
  usb.change("connect", usb.devices[0]!);
  expect([seen.at(-1), (await serial.getPorts())[0] === port]).toEqual(["connect", false]);
});

it("each chip has its driver", () => {
  expect([ftdi(), ch340(), cp210x(), pl2303(), cdcAcm(), keyboard()].map(familyOf)).toEqual([
    "ftdi",
    "ch34x",
    "cp210x",
    "pl2303",
    "cdc-acm",
    null,
  ]);
});

it("the chips that the program names have a driver, each by its maker", () => {
  const table = readFileSync(new URL("../../../../src/mikas/link/chips.py", import.meta.url), "utf-8");
  const chips = [...table.matchAll(/^ {4}\(0x([0-9A-F]{4}), (?:0x([0-9A-F]{4})|0)\): \("(\w+)"/gm)];
  expect(chips.length).toBeGreaterThan(20);
  const drivers = Object.fromEntries(
    chips.map(([, vendor, product, name]) => [name, driver(parseInt(vendor!, 16), parseInt(product ?? "0", 16))]),
  );
  expect(drivers).toMatchObject({ FT232R: "ftdi", FT2232: "ftdi", CH340: "ch34x", CH341: "ch34x", CP210x: "cp210x", CP2108: "cp210x" });
  expect(drivers).toMatchObject({ PL2303: "pl2303", PL2303GC: "pl2303" });
  // These are CDC-ACM devices, which are known by their class.
  const others = Object.keys(drivers).filter((name) => drivers[name] === null);
  expect(others.sort()).toEqual(["CH342", "CH343", "CH9102", "MCP2200", "MCP2221", "XR21V1410"]);

  function driver(vendor: number, product: number): string | null {
    const endpoints = ftdi().configurations;
    return familyOf(new ScriptedUsb(vendor, product, endpoints, 0));
  }
});
