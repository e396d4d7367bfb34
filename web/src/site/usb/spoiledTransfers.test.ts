import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { ch340 } from "../../../test/scriptedUsb";
import { heard, opened, settled, write } from "../../../test/usbPort";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

describe("a transfer that is kept with another status", () => {
  it("stalls: the endpoint is cleared, and bytes go on", async () => {
    const device = ch340();
    const all = heard(await opened(device));
    device.spoil("stall");
    await settled();
    expect([device.halted, device.ahead()]).toEqual([["in 2"], 7]);
    device.send([1]);
    await settled();
    expect(all).toEqual([1]);
  });

  it("stalls while others of before wait on: these go on when the endpoint is cleared", async () => {
    const device = ch340();
    const all = heard(await opened(device));
    device.spoil("stall", 1);
    await settled();
    expect([device.halted, device.ahead()]).toEqual([["in 2"], 7]);
    for (let i = 0; i < 9; i++) device.send([i]);
    await settled();
    expect(all).toEqual([0, 1, 2, 3, 4, 5, 6, 7, 8]);
  });

  it("stalls again and again: the port is lost", async () => {
    const device = ch340();
    const port = await opened(device);
    const all = heard(port);
    for (let i = 0; i < 4; i++) {
      device.spoil("stall");
      await settled();
    }
    expect(all).toEqual(["StallError", "no stream"]);
    await expect(write(port, 1)).rejects.toMatchObject({ name: "StallError" });
  });

  it("babbles: bytes were lost, and others go on", async () => {
    const device = ch340();
    const all = heard(await opened(device));
    device.spoil("babble");
    device.send([1]);
    await settled();
    expect([...all, device.ahead()]).toEqual(["BufferOverrunError", 1, 7]);
  });

  it("babbles again and again: the port is lost", async () => {
    const device = ch340();
    const all = heard(await opened(device));
    for (let i = 0; i < 4; i++) device.spoil("babble");
    await settled();
    expect(all.at(-2)).toBe("StallError");
  });
});
