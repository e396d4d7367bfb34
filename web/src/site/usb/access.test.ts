import { expect, it, vi } from "vitest";
import { ch340, ftdi, type ScriptedUsb } from "../../../test/scriptedUsb";
import { nameOf, partsOf } from "../program/messages";
import { accessOf, adaptersBy, memoryIsScarce } from "./access";

const PHONE = "Mozilla/5.0 (Linux; Android 10; K) AppleWebKit/537.36 Chrome/156.0.0.0 Mobile Safari/537.36";
const PC = "Mozilla/5.0 (X11; Linux x86_64) AppleWebKit/537.36 Chrome/156.0.0.0 Safari/537.36";
const WINDOWS = "Mozilla/5.0 (Windows NT 10.0; Win64; x64) AppleWebKit/537.36 Chrome/156.0.0.0 Safari/537.36";

class FakeSerial extends EventTarget {
  constructor(readonly ports: object[] | null) {
    super();
  }
  getPorts = (): Promise<object[]> => (this.ports ? Promise.resolve(this.ports) : new Promise(() => undefined));
}

const port = (usbVendorId?: number, usbProductId?: number) => ({ getInfo: () => ({ usbVendorId, usbProductId }) });
const usbOf = (...devices: ScriptedUsb[]) => Object.assign(new EventTarget(), { getDevices: async () => devices });

it("a computer has Web Serial, a phone WebUSB, whatever else they have", () => {
  const [serial, usb] = [new FakeSerial([]) as never, usbOf() as never];
  const access = (userAgent: string, touched: boolean, has: object) => accessOf({ userAgent, ...has } as never, touched);
  expect(access(PC, false, { serial, usb })).toBe("serial");
  expect(access(WINDOWS, true, { serial, usb })).toBe("serial");
  expect(access(PHONE, true, { serial, usb })).toBe("usb");
  expect(access(PHONE, true, { usb })).toBe("usb");
  expect(access(PHONE, true, { serial })).toBe("serial");
  expect(access(PC, false, { usb })).toBe("none");
  expect(access(PC, false, {})).toBe("none");
});

it("a phone that was asked for a page as on a computer is a phone", () => {
  expect(accessOf({ userAgent: PC, serial: new FakeSerial([]), usb: usbOf() } as never, true)).toBe("usb");
});

it("a worker learns by its name what the page has decided", () => {
  expect(partsOf(nameOf("line", "usb"))).toEqual(["line", "usb"]);
  expect(partsOf(nameOf("reader", "serial"))).toEqual(["reader", "serial"]);
  expect(partsOf("")).toEqual(["line", "none"]);
});

it("a phone's Web Serial comes first where it lists a cable, and each cable is listed once", async () => {
  const own = port(0x0403, 0x6001);
  vi.stubGlobal("navigator", { userAgent: PHONE, serial: new FakeSerial([own]), usb: usbOf(ftdi(), ch340()) });
  const [first, ...others] = await adaptersBy("usb")!.getPorts();
  expect([first, ...others.map((it) => it.getInfo().usbVendorId)]).toEqual([own, 0x1a86]);
});

it("a phone's Web Serial may list nothing, and never answer", async () => {
  vi.useFakeTimers();
  vi.stubGlobal("navigator", { userAgent: PHONE, serial: new FakeSerial(null), usb: usbOf(ftdi()) });
  const listed = adaptersBy("usb")!.getPorts();
  await vi.advanceTimersByTimeAsync(500);
  expect((await listed).map((it) => it.scheme)).toEqual(["webusb"]);
  vi.useRealTimers();
});

it("what comes or goes by either way is an event", () => {
  const [serial, usb] = [new FakeSerial([]), usbOf()];
  vi.stubGlobal("navigator", { userAgent: PHONE, serial, usb });
  const seen = vi.fn();
  adaptersBy("usb")!.addEventListener("connect", seen);
  serial.dispatchEvent(new Event("connect"));
  usb.dispatchEvent(Object.assign(new Event("connect"), { device: ftdi() }));
  expect(seen).toHaveBeenCalledTimes(2);
});

it("on a computer the adapters are the browser's own", () => {
  const serial = new FakeSerial([]);
  vi.stubGlobal("navigator", { userAgent: PC, serial, usb: usbOf() });
  expect([adaptersBy("serial"), adaptersBy("none")]).toEqual([serial, undefined]);
});

it("memory is scarce on any phone, and on a computer with little of it", () => {
  expect(memoryIsScarce({ userAgent: PHONE, deviceMemory: 8 }, true)).toBe(true);
  expect(memoryIsScarce({ userAgent: PC }, true)).toBe(true); // a page as on a computer
  expect(memoryIsScarce({ userAgent: WINDOWS, deviceMemory: 2 }, false)).toBe(true);
  expect(memoryIsScarce({ userAgent: WINDOWS, deviceMemory: 4 }, true)).toBe(false);
  expect(memoryIsScarce({ userAgent: PC }, false)).toBe(false); // Firefox does not say how much there is
});
