import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { FakePort, hostOf, opened, python } from "../../../test/serialRig";
import { now, OpenPort, SerialHost, type Refusal } from "./serial";
import type { SerialPort } from "./webSerial";

const names = async (host: SerialHost) => (await host.ports().promise).map(({ vid, pid, nth }) => [vid, pid, nth]);

describe("the granted ports", () => {
  it("are numbered among their kind", async () => {
    const ch340 = { usbVendorId: 0x1a86, usbProductId: 0x7523 };
    const host = hostOf(new FakePort(), new FakePort(ch340), new FakePort(), new FakePort({}));
    expect(await names(host)).toEqual([
      [0x0403, 0x6001, 1],
      [0x1a86, 0x7523, 1],
      [0x0403, 0x6001, 2],
      [undefined, undefined, 1],
    ]);
  });

  it("keep their number while another of the kind is away", async () => {
    const [first, second, again] = [new FakePort(), new FakePort(), new FakePort()];
    let there = [first, second];
    const host = new SerialHost(Object.assign(new EventTarget(), { getPorts: async () => there }));
    const numbers = async () => new Map((await host.ports().promise).map(({ port, nth }) => [port, nth]));
    await host.ports().promise;
    there = [second];
    expect(await numbers()).toEqual(new Map([[second, 2]]));
    there = [again, second];
    expect(await numbers()).toEqual(
      new Map([
        [second, 2],
        [again, 1],
      ]),
    );
  });

  it("are those that are plugged in", async () => {
    const away = new FakePort();
    away.connected = false;
    expect(await names(hostOf(away))).toEqual([]);
    expect(await names(new SerialHost(undefined))).toEqual([]);
  });
});

describe("opening", () => {
  it("has a large buffer, and sets the lines", async () => {
    const port = new FakePort();
    await opened(port, true, false);
    expect(port.opened).toEqual([{ baudRate: 9600, bufferSize: 65536 }]);
    expect(port.signals).toEqual([{ dataTerminalReady: true, requestToSend: false }]);
  });

  it("needs no lines that an adapter lacks", async () => {
    const port = new FakePort();
    port.refusesSignals = true;
    expect((await opened(port)).lost).toBe("");
  });

  it("tells why not", async () => {
    const port = new FakePort();
    port.refuses = new DOMException("Failed to open serial port.", "NetworkError");
    const refusal = (await opened(port)) as unknown as Refusal;
    expect(refusal).toEqual({ refused: "NetworkError", message: "Failed to open serial port." });
  });

  it("waits until the port is closed", async () => {
    const port = new FakePort();
    const host = hostOf(port);
    const [granted] = await host.ports().promise;
    const first = (await host.open(granted!, 9600, true, false).promise) as OpenPort;
    first.close();
    const second = (await host.open(granted!, 9600, true, false).promise) as OpenPort;
    expect([port.closed, second.lost]).toEqual([1, ""]);
  });
});

describe("a port with a driver of this page", () => {
  const usb = (facts: object) => Object.assign(new FakePort(), { scheme: "webusb", ...facts });

  it("has a scheme of its own, and is numbered among its kind", async () => {
    const host = hostOf(new FakePort(), usb({ serialNumber: "A1" }), usb({ serialNumber: "" }));
    const ports = (await host.ports().promise).map(({ scheme, nth, serialNumber }) => [scheme, nth, serialNumber]);
    expect(ports).toEqual([
      ["webserial", 1, ""],
      ["webusb", 1, "A1"],
      ["webusb", 2, ""],
    ]);
  });

  it("says how late its chip is; the browser's own does not", async () => {
    expect([(await opened(usb({ granularity: 0.001 }))).granularity, (await opened()).granularity]).toEqual([0.001, 0]);
  });

  it("is refused where its chip makes another rate, and closed", async () => {
    const port = usb({ rate: 14_400.2 });
    expect(await opened(port)).toEqual({ refused: "RateError", message: "14400" });
    expect(port.closed).toBe(1);
    expect((await opened(usb({ rate: 9615 }))).lost).toBe("");
  });

  it("may take its own time to open: a phone asks its user", async () => {
    vi.useFakeTimers();
    const port = usb({ patience: 70_000 });
    const open = port.open.bind(port);
    port.open = (options) => new Promise((opened) => setTimeout(() => opened(open(options)), 60_000));
    const found = opened(port);
    await vi.advanceTimersByTimeAsync(60_000);
    expect((await found).lost).toBe("");
    vi.useRealTimers();
  });

  it("whose chip refuses transfers is lost for that reason", async () => {
    const port = usb({});
    const link = await opened(port);
    await settled();
    port.fail("StallError", true);
    await settled();
    expect(link.lost).toBe("stalled");
  });
});

describe("a page that is not shown any more", () => {
  it("lets its ports go, and has them again when it is shown", async () => {
    const [port, other] = [new FakePort(), new FakePort()];
    const host = hostOf(port, other);
    const [first, second] = await host.ports().promise;
    const [link, closed] = [await host.open(first!, 9600, true, false).promise, await host.open(second!, 9600, true, false).promise];
    (closed as OpenPort).close();
    host.release(true);
    expect([(link as OpenPort).lost, (closed as OpenPort).lost]).toEqual(["unplugged", "closed"]);
    expect([port.closed, await names(host)]).toEqual([1, []]);
    host.release(false);
    expect(await names(host)).toHaveLength(2);
    expect(((await host.open(first!, 9600, true, false).promise) as OpenPort).lost).toBe("");
  });
});

describe("a browser that settles nothing, as with a driver that hangs,", () => {
  const never = new Promise<never>(() => undefined);
  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => void vi.useRealTimers());

  /** What comes of it when all the time that it may take has passed. */
  async function soon<T>(promise: Promise<T>): Promise<T> {
    await vi.advanceTimersByTimeAsync(20_000);
    return promise;
  }

  it("does not open a port: that is said, and what opens too late is closed", async () => {
    const port = new FakePort();
    const host = hostOf(port);
    const [granted] = await host.ports().promise;
    let open: () => void = () => undefined;
    port.open = () => new Promise<void>((resolve) => (open = resolve));
    expect(await soon(host.open(granted!, 9600, true, false).promise)).toMatchObject({ refused: "TimeoutError" });
    open();
    await vi.advanceTimersByTimeAsync(0);
    expect(port.closed).toBe(1);
  });
  it("has lines that are not set: the port is used without", async () => {
    const port = new FakePort();
    port.setSignals = () => never;
    const found = await soon(opened(port));
    expect(found.lost).toBe("");
    expect(await soon(found.pullLow(true).promise)).toBe(false);
  });
  it("does not close a port: the next one that wants it is refused", async () => {
    const port = new FakePort();
    const host = hostOf(port);
    const [granted] = await host.ports().promise;
    port.close = () => never;
    ((await host.open(granted!, 9600, true, false).promise) as OpenPort).close();
    expect(await soon(host.open(granted!, 9600, true, false).promise)).toMatchObject({ refused: "TimeoutError" });
  });
  it("has no list of ports: the one before counts", async () => {
    const [port, serial] = [new FakePort(), Object.assign(new EventTarget(), { getPorts: async () => [port] as SerialPort[] })];
    const host = new SerialHost(serial);
    expect(await names(host)).toEqual([[0x0403, 0x6001, 1]]);
    serial.getPorts = () => never;
    expect(await soon(names(host))).toEqual([[0x0403, 0x6001, 1]]);
  });
});

describe("bytes that come", () => {
  it("have the time of their arrival, however late they are taken", async () => {
    const port = new FakePort();
    const link = await opened(port);
    const arrival = link.arrival(now() + 60);
    port.send(1, 2);
    port.send(3);
    await arrival?.promise;
    await settled();
    const came = now();
    vi.spyOn(performance, "now").mockReturnValue(performance.now() + 5000);
    expect([...link.take()!]).toEqual([1, 2, 3]);
    expect(link.takenAt).toBeLessThanOrEqual(came);
    expect(link.take()).toBeUndefined();
  });

  it("are waited for until a deadline, never shorter", async () => {
    const link = await opened();
    const deadline = now() + 0.02;
    await link.arrival(deadline)?.promise;
    expect(now()).toBeGreaterThanOrEqual(deadline);
    expect(link.take()).toBeUndefined();
  });

  it("are looked for after a deadline in the past too", async () => {
    const port = new FakePort();
    const link = await opened(port);
    port.send(7);
    await link.arrival(now() - 60)?.promise;
    expect([...link.take()!]).toEqual([7]);
    expect(link.arrival(now() - 60)).toBeUndefined(); // just now
    vi.spyOn(performance, "now").mockReturnValue(performance.now() + 5);
    expect(link.arrival(now() - 60)).toBeDefined();
  });

  it("gather until a time", async () => {
    const port = new FakePort();
    const link = await opened(port);
    const time = now() + 0.02;
    port.send(7);
    await link.gathering(time).promise;
    expect(now()).toBeGreaterThanOrEqual(time);
    expect(link.arrival(now() + 60)).toBeUndefined();
  });

  it.each(["BreakError", "FramingError", "ParityError", "BufferOverrunError"])("go on after a %s", async (name) => {
    const port = new FakePort();
    const link = await opened(port);
    await settled();
    port.fail(name, false);
    await settled();
    port.send(9);
    await link.arrival(now() + 60)?.promise;
    expect([[...link.take()!], link.lost]).toEqual([[9], ""]);
  });
});

describe("a lost port", () => {
  it("is told to the one who waits, and is closed", async () => {
    const port = new FakePort();
    const link = await opened(port);
    const arrival = link.arrival(now() + 60);
    port.fail("NetworkError", true);
    await arrival?.promise;
    await settled();
    expect([link.lost, port.closed]).toEqual(["unplugged", 1]);
    expect(link.arrival(now() + 60)).toBeUndefined();
  });

  it("may be told by the browser only", async () => {
    const port = new FakePort();
    const link = await opened(port);
    port.dispatchEvent(new Event("disconnect"));
    expect(link.lost).toBe("unplugged");
  });

  it("hands over what came before", async () => {
    const port = new FakePort();
    const link = await opened(port);
    port.send(5);
    await link.arrival(now() + 60)?.promise;
    port.dispatchEvent(new Event("disconnect"));
    expect([...link.take()!]).toEqual([5]);
  });

  it("has another reason in the browser's words", async () => {
    const port = new FakePort();
    const link = await opened(port);
    await settled();
    port.fail("UnknownError", true);
    await settled();
    expect(link.lost).toBe("it was UnknownError");
  });

  it("wakes the one who waits when it is closed here", async () => {
    const link = await opened();
    const arrival = link.arrival(now() + 60);
    link.close();
    link.close();
    await arrival?.promise;
    expect([link.lost, link.take()]).toEqual(["closed", undefined]);
  });
});

describe("bytes that go", () => {
  it("are written", async () => {
    const port = new FakePort();
    const link = await opened(port);
    await link.write(python(1, 255), 2).promise;
    expect([port.written, link.lost]).toEqual([[1, 255], ""]);
  });

  it("end in a loss when the port takes none", async () => {
    const port = new FakePort();
    port.takes = new Promise(() => undefined);
    const link = await opened(port);
    await link.write(python(1), 0.001).promise;
    expect(link.lost).toBe("stuck");
  });

  it("end in a loss when the port fails", async () => {
    const port = new FakePort();
    port.takes = Promise.reject(new DOMException("The device has been lost.", "NetworkError"));
    const link = await opened(port);
    await link.write(python(1), 2).promise;
    expect(link.lost).toBe("unplugged");
    await link.write(python(1), 2).promise;
  });

  it("may be a break, if the adapter can", async () => {
    const port = new FakePort();
    const link = await opened(port);
    expect(await link.pullLow(true).promise).toBe(true);
    expect(port.signals.at(-1)).toEqual({ break: true });
    port.refusesSignals = true;
    expect(await link.pullLow(false).promise).toBe(false);
  });
});

/** After all that the streams have to do. */
const settled = () => new Promise((resolve) => setImmediate(resolve));
