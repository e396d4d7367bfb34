import { afterEach, expect, it, vi } from "vitest";
import { ch340, ftdi as ftdiDevice } from "../../../test/scriptedUsb";
import { followAdapters } from "../worker/adapters";
import { canChoose, choice, choosePort, findAdapters } from "./adapters.svelte";

const port = (usbVendorId?: number, usbProductId?: number) => ({ getInfo: () => ({ usbVendorId, usbProductId }) });
const ftdi = () => port(0x0403, 0x6001);

class FakeSerial extends EventTarget {
  requestPort = vi.fn();
  constructor(readonly ports: object[]) {
    super();
  }
  getPorts = async () => [...this.ports];

  change(kind: "connect" | "disconnect"): void {
    this.dispatchEvent(new Event(kind));
  }
}

/** The page, in a browser whose user chooses `chosen`, one after the other. */
function page(ports: object[], ...chosen: object[]): FakeSerial {
  const serial = new FakeSerial(ports);
  for (const each of chosen) serial.requestPort.mockResolvedValueOnce(each);
  vi.stubGlobal("navigator", { serial, userAgent: "X11; Linux x86_64" });
  findAdapters();
  return serial;
}

afterEach(() => {
  choice.cancelled = choice.unknown = false;
});

it("a port is named by the ids of its chip", async () => {
  const [one, other] = [ftdi(), port()];
  page([one, other], one, other);
  expect([await choosePort(), await choosePort()]).toEqual(["webserial:0403:6001", "webserial:other"]);
});

it("of two like adapters the chosen one is named", async () => {
  const [first, second] = [ftdi(), ftdi()];
  page([first, second], second, first);
  expect([await choosePort(), await choosePort()]).toEqual(["webserial:0403:6001:2", "webserial:0403:6001"]);
});

it("like adapters have the same names in the page and in the worker, whichever comes and goes", async () => {
  const [first, second, third] = [ftdi(), ftdi(), ftdi()];
  const serial = page([second], first);
  const worker = followAdapters(serial as never);
  const change = (kind: "connect" | "disconnect", ...now: object[]) => {
    serial.ports.splice(0, Infinity, ...now);
    serial.change(kind);
    return new Promise((looked) => setTimeout(looked));
  };
  await change("connect", first, second);
  expect(await choosePort()).toBe("webserial:0403:6001:2");
  await change("disconnect", first);
  await change("connect", third, first);
  const numbers = (await worker.ports().promise).map(({ port, nth }) => [port, nth]);
  expect(numbers).toEqual([
    [first, 2],
    [third, 1],
  ]);
  serial.requestPort.mockResolvedValueOnce(third);
  expect(await choosePort()).toBe("webserial:0403:6001");
});

it("closing the list without a choice is no error, and is remembered until one is made", async () => {
  const chosen = ftdi();
  const { requestPort } = page([chosen]);
  requestPort.mockRejectedValueOnce(new DOMException("none", "NotFoundError")).mockResolvedValueOnce(chosen);
  expect(canChoose()).toBe(true);
  expect([await choosePort(), choice.cancelled]).toEqual([null, true]);
  expect([await choosePort(), choice.cancelled]).toEqual(["webserial:0403:6001", false]);
});

it("a browser without Web Serial has no list", async () => {
  vi.stubGlobal("navigator", { userAgent: "Safari" });
  expect([canChoose(), await choosePort(), choice.cancelled]).toEqual([false, null, false]);
});

it("on a phone the list is that of WebUSB, whose ports have a scheme of their own", async () => {
  const [one, other] = [ftdiDevice(), ftdiDevice()];
  const usb = Object.assign(new EventTarget(), { getDevices: async () => [one, other], requestDevice: vi.fn() });
  usb.requestDevice
    .mockResolvedValueOnce(other)
    .mockRejectedValueOnce(new DOMException("none", "NotFoundError"))
    .mockResolvedValueOnce(ch340());
  vi.stubGlobal("navigator", { usb, userAgent: "Mozilla/5.0 (Linux; Android 10; K)" });
  findAdapters();
  expect(canChoose()).toBe(true);
  expect(await choosePort()).toBe("webusb:0403:6001:2");
  expect([await choosePort(), choice.cancelled, choice.unknown]).toEqual([null, true, false]);
  expect([await choosePort(), choice.cancelled]).toEqual([null, false]); // pulled again before it was looked for
});

it("what was chosen may be no serial port", async () => {
  const requestDevice = vi.fn().mockResolvedValueOnce(Object.assign(ch340(), { productId: 0x5512 }));
  const usb = Object.assign(new EventTarget(), { getDevices: async () => [], requestDevice });
  vi.stubGlobal("navigator", { usb, userAgent: "Mozilla/5.0 (Linux; Android 10; K)" });
  findAdapters();
  expect([await choosePort(), choice.cancelled, choice.unknown]).toEqual([null, false, true]);
});
