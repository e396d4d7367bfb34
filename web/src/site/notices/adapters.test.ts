import { afterEach, expect, it, vi } from "vitest";
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
  vi.stubGlobal("navigator", { serial });
  findAdapters();
  return serial;
}

afterEach(() => {
  choice.cancelled = false;
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
  vi.stubGlobal("navigator", {});
  expect([canChoose(), await choosePort(), choice.cancelled]).toEqual([false, null, false]);
});
