import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { cdcAcm, ch340, cp210x, ftdi, pl2303 } from "../../../test/scriptedUsb";
import { heard, opened, OPTIONS, settled, write } from "../../../test/usbPort";
import { UsbSerialPort } from "./usbSerialPort";

/** The head of an FTDI's packet without errors. */
const HEAD = [0x01, 0x60];

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

describe("opening", () => {
  it("claims the port, starts the chip, and has transfers under way", async () => {
    const device = ftdi();
    const port = await opened(device);
    expect([device.claimed, device.ahead(), port.rate, port.granularity]).toEqual([[0], 8, 9600, 0.016]);
    expect(port.getInfo()).toEqual({ usbVendorId: 0x0403, usbProductId: 0x6001 });
    expect([port.scheme, port.connected, port.serialNumber]).toEqual(["webusb", true, "A1"]);
  });

  it("claims both interfaces of CDC-ACM", async () => {
    const device = cdcAcm();
    await opened(device);
    expect([device.claimed, device.ahead(2), device.ahead(3)]).toEqual([[0, 1], 8, 1]);
  });

  it("says what rate the chip makes", async () => {
    const port = new UsbSerialPort(cp210x());
    await port.open({ ...OPTIONS, baudRate: 10_400 });
    expect(port.rate).toBe(14_400);
  });

  it("twice is refused", async () => {
    const port = new UsbSerialPort(ftdi());
    const first = port.open(OPTIONS);
    await expect(port.open(OPTIONS)).rejects.toMatchObject({ name: "InvalidStateError" });
    await first;
    await expect(port.open(OPTIONS)).rejects.toMatchObject({ name: "InvalidStateError" });
  });

  it("is refused by a driver or a program that has the device", async () => {
    const device = ch340();
    device.refusesClaim = true;
    await expect(opened(device)).rejects.toMatchObject({ name: "ClaimError" });
    expect(device.opened).toBe(false);
    device.refusesClaim = false;
    await opened(device);
  });

  it("of a device that is pulled meanwhile is no question of drivers", async () => {
    const device = ch340();
    vi.spyOn(device, "selectConfiguration").mockImplementation(async () => device.pull());
    await expect(opened(device)).rejects.toMatchObject({ name: "NotFoundError" });
  });

  it("is refused where the system does not allow it", async () => {
    const device = ftdi();
    device.refusesOpen = new DOMException("Access denied.", "SecurityError");
    await expect(opened(device)).rejects.toMatchObject({ name: "SecurityError" });
  });

  it("is refused for a line that the chip can't, and by a chip that refuses", async () => {
    const port = new UsbSerialPort(ftdi());
    await expect(port.open({ ...OPTIONS, dataBits: 5 })).rejects.toMatchObject({ name: "NotSupportedError" });
    const device = ch340();
    device.answers.push(["40 9a", "stall"]);
    await expect(opened(device)).rejects.toMatchObject({ name: "ChipError" });
    expect(device.opened).toBe(false);
  });

  it("ends, though the browser settles nothing", async () => {
    const device = ftdi();
    device.hangs = "open";
    const refused = expect(opened(device)).rejects.toMatchObject({ name: "TimeoutError" });
    await vi.advanceTimersByTimeAsync(70_000);
    await refused;
  });
});

describe("bytes that come", () => {
  it("lose the status bytes of an FTDI at each packet", async () => {
    const device = ftdi();
    const all = heard(await opened(device));
    const long = Array.from({ length: 62 }, (_, i) => i);
    device.send([...HEAD, ...long]);
    device.send(HEAD);
    device.send([...HEAD, 200]);
    await settled();
    expect(all).toEqual([...long, 200]);
    expect(device.ahead()).toBe(7);
  });

  it("are answered before the next transfer is begun, which would be in the way", async () => {
    const device = ftdi();
    const port = await opened(device);
    const calls: string[] = [];
    const [begun, written] = [vi.spyOn(device, "transferIn"), vi.spyOn(device, "transferOut")];
    begun.mockImplementationOnce(() => (calls.push("in"), new Promise(() => undefined)));
    written.mockImplementationOnce(async () => (calls.push("out"), { status: "ok", bytesWritten: 1 }));
    const reader = port.readable!.getReader();
    const answered = reader.read().then(() => write(port, 9));
    device.send([...HEAD, 1]);
    await answered;
    device.send([...HEAD, 2]);
    await settled();
    expect(calls).toEqual(["out", "in"]);
  });

  it.each([
    ["a CH340", ch340],
    ["a CP2102", cp210x],
    ["a PL2303", pl2303],
    ["a CDC-ACM device", cdcAcm],
  ])("are those of %s", async (_, make) => {
    const device = make();
    const all = heard(await opened(device));
    device.send([1, 2, 3]);
    device.send([]);
    device.send([4]);
    await settled();
    expect(all).toEqual([1, 2, 3, 4]);
  });

  it("go on after an error of the wire, which loses none of them", async () => {
    const device = ftdi();
    const all = heard(await opened(device));
    device.send([...HEAD, 1]);
    device.send([0x01, 0x68, 2]);
    device.send([...HEAD, 3]);
    device.send([0x01, 0x62, 4]);
    device.send([...HEAD, 5]);
    await settled();
    expect(all).toEqual([1, 2, "FramingError", 3, 4, "BufferOverrunError", 5]);
  });

  it("have errors that come beside them, of a PL2303 and CDC-ACM", async () => {
    for (const [device, endpoint] of [[pl2303(), 1] as const, [cdcAcm(), 3] as const]) {
      const all = heard(await opened(device));
      device.send([0xa1, 0x20, 0, 0, 0, 0, 2, 0, 0x04, 0], endpoint);
      device.send([0xa1, 0x20, 0, 0, 0, 0, 2, 0, 0x10, 0], endpoint);
      await settled();
      device.send([7]);
      await settled();
      expect(all).toEqual(["BreakError", "FramingError", 7]);
    }
  });

  it("have errors that a CP210x must be asked for", async () => {
    const device = cp210x();
    const all = heard(await opened(device));
    device.answers.push(["c1 10", [0x02, ...new Array<number>(18).fill(0)]]);
    await vi.advanceTimersByTimeAsync(3500);
    expect(all).toEqual(["FramingError"]);
    expect(device.asked.filter((it) => it.startsWith("c1 10"))).toHaveLength(3);
  });

  it("are kept until they are read, and no more than the buffer has", async () => {
    const device = ch340();
    const port = new UsbSerialPort(device);
    await port.open({ ...OPTIONS, bufferSize: 4 });
    device.send([1, 2, 3]);
    device.send([4, 5]);
    device.send([6, 7]);
    device.send([8]);
    await settled();
    const all = heard(port);
    await settled();
    expect(all).toEqual([1, 2, 3, "BufferOverrunError", 8]);
  });

  it("go to the next stream when a reader has cancelled one", async () => {
    const device = ch340();
    const port = await opened(device);
    await port.readable!.cancel();
    device.send([1]);
    const all = heard(port);
    await settled();
    expect(all).toEqual([1]);
  });

  it("are in order, however the browser settles the transfers", async () => {
    const device = ch340();
    const all = heard(await opened(device));
    for (let i = 0; i < 20; i++) device.send([i]);
    await settled();
    expect(all).toEqual(Array.from({ length: 20 }, (_, i) => i));
  });
});

describe("bytes that go", () => {
  it("are written, also where a transfer takes only some", async () => {
    const device = ftdi();
    const port = await opened(device);
    device.takes = 2;
    await write(port, 1, 2, 3);
    expect(device.written).toEqual([[1, 2], [3]]);
  });

  it("end in an error when the chip takes none", async () => {
    const device = ftdi();
    const port = await opened(device);
    device.writes = "stall";
    await expect(write(port, 1)).rejects.toMatchObject({ name: "StallError" });
    expect(device.halted).toEqual(["out 2"]);
  });
});

describe("signals", () => {
  it("are set, each for itself", async () => {
    const device = cp210x();
    const port = await opened(device);
    device.asked = [];
    await port.setSignals({ dataTerminalReady: true, requestToSend: false });
    await port.setSignals({ requestToSend: true });
    await port.setSignals({ break: true });
    expect(device.asked).toEqual(["41 07 0301 0000", "41 07 0303 0000", "41 05 0001 0000"]);
  });

  it("are refused by a chip that has none, or is closed, or hangs", async () => {
    const device = pl2303();
    device.answers.push(["21 23", "stall"], ["21 22", "hang"]);
    const port = await opened(device);
    await expect(port.setSignals({ break: true })).rejects.toMatchObject({ name: "ChipError" });
    const hangs = expect(port.setSignals({ dataTerminalReady: true })).rejects.toMatchObject({ name: "TimeoutError" });
    await vi.advanceTimersByTimeAsync(2000);
    await hangs;
    await port.close();
    await expect(port.setSignals({ break: true })).rejects.toMatchObject({ name: "InvalidStateError" });
  });
});

describe("a pull", () => {
  it("amid transfers is seen by the reader at once, and once", async () => {
    const device = ftdi();
    const port = await opened(device);
    const all = heard(port);
    device.send([...HEAD, 1]);
    device.pull();
    await settled();
    port.unplug();
    await settled();
    expect([all, port.readable, port.connected]).toEqual([[1, "NetworkError", "no stream"], null, false]);
    await expect(write(port, 1)).rejects.toMatchObject({ name: "NetworkError" });
    await port.close();
  });

  it("may be reported by the browser first", async () => {
    const device = ftdi();
    const port = await opened(device);
    const all = heard(port);
    const seen = vi.fn();
    port.addEventListener("disconnect", seen);
    port.unplug();
    device.pull();
    await settled();
    expect([all, seen.mock.calls.length]).toEqual([["NetworkError", "no stream"], 1]);
  });

  it("amid a write is an error", async () => {
    const device = ftdi();
    const port = await opened(device);
    device.pull();
    await expect(write(port, 1)).rejects.toMatchObject({ name: "NetworkError" });
  });

  it("leaves a port that can be closed, and a device that is new when it is back", async () => {
    const device = ftdi();
    const port = await opened(device);
    device.pull();
    await settled();
    await port.close();
    await expect(port.open(OPTIONS)).rejects.toMatchObject({ name: "NotFoundError" });
    const back = ftdi();
    const all = heard(await opened(back));
    back.send([...HEAD, 9]);
    await settled();
    expect(all).toEqual([9]);
  });
});

describe("closing", () => {
  it("ends the streams, and lets the device go", async () => {
    const device = cp210x();
    const port = await opened(device);
    const all = heard(port);
    await port.close();
    await settled();
    expect([all, device.opened, port.readable, port.writable]).toEqual([["end"], false, null, null]);
    expect(device.asked.slice(-2)).toEqual(["41 12 000f 0000", "41 00 0000 0000"]);
    await port.close();
  });

  it("and opening at once: the port is opened when it is closed", async () => {
    const device = cp210x();
    const port = await opened(device);
    device.asked = [];
    const closed = port.close();
    await port.open(OPTIONS);
    await closed;
    expect(device.asked.slice(0, 3)).toEqual(["41 12 000f 0000", "41 00 0000 0000", "c0 ff 370b 0000"]);
    expect([device.opened, device.ahead(), port.readable !== null]).toEqual([true, 8, true]);
  });

  it("and opening again: transfers of before, which end later, harm nothing", async () => {
    const device = ftdi();
    const port = await opened(device);
    await port.close();
    await port.open(OPTIONS);
    const all = heard(port);
    await settled();
    device.send([...HEAD, 3]);
    await settled();
    expect([all, device.ahead()]).toEqual([[3], 7]);
  });

  it("ends, though the browser never closes the device", async () => {
    const device = ftdi();
    const port = await opened(device);
    device.hangs = "close";
    const closed = port.close();
    await vi.advanceTimersByTimeAsync(4000);
    await closed;
    device.hangs = null;
    await port.open(OPTIONS);
    expect(device.claimed).toEqual([0]);
  });
});
