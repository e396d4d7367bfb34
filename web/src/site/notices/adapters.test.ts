import { afterEach, expect, it, vi } from "vitest";
import { canChoose, choice, choosePort } from "./adapters.svelte";

const port = (usbVendorId?: number, usbProductId?: number) => ({ getInfo: () => ({ usbVendorId, usbProductId }) });

afterEach(() => {
  choice.cancelled = false;
});

it("a port is named by the ids of its chip", async () => {
  const requestPort = vi.fn().mockResolvedValueOnce(port(0x0403, 0x6001)).mockResolvedValueOnce(port());
  vi.stubGlobal("navigator", { serial: { requestPort } });
  expect([await choosePort(), await choosePort()]).toEqual(["webserial:0403:6001", "webserial:other"]);
});

it("closing the list without a choice is no error, and is remembered until one is made", async () => {
  const requestPort = vi.fn().mockRejectedValueOnce(new DOMException("none", "NotFoundError"));
  const chosen = port(0x0403, 0x6001);
  requestPort.mockResolvedValueOnce(chosen);
  vi.stubGlobal("navigator", { serial: { requestPort } });
  expect(canChoose()).toBe(true);
  expect([await choosePort(), choice.cancelled]).toEqual([null, true]);
  expect([await choosePort(), choice.cancelled]).toEqual(["webserial:0403:6001", false]);
});

it("a browser without Web Serial has no list", async () => {
  vi.stubGlobal("navigator", {});
  expect([canChoose(), await choosePort(), choice.cancelled]).toEqual([false, null, false]);
});
