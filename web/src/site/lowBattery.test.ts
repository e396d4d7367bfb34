import { beforeEach, expect, it, vi } from "vitest";
import type { State } from "../lib/api/types";
import { served } from "../lib/platform/host";
import { Stores } from "../stores";
import { LowBattery } from "./lowBattery";

const state = (recording: object | null): State => ({ line: "sampling", port: "webusb:0403:6001", recording }) as State;
let stores: Stores;
let lowBattery: LowBattery;
let stop: ReturnType<typeof vi.spyOn>;

beforeEach(() => {
  stores = new Stores(served);
  lowBattery = new LowBattery(stores);
  stop = vi.spyOn(stores.api, "stopRecording").mockImplementation(() => {
    stores.live.state = state(null);
    return Promise.resolve(stores.live.state);
  });
  stores.live.state = state({ file: "a.pcapng" });
});

const said = () => stores.toasts.shown.map(({ text }) => text());

it("warns once at 20 %, and again only after a charge", async () => {
  for (const left of [64, 21, null]) await lowBattery.follow(left);
  expect(said()).toEqual([]);
  for (const left of [20, 19, 18]) await lowBattery.follow(left);
  expect(said()).toEqual([expect.stringContaining("Battery at 20 %. The phone does not charge while the cable is in it")]);
  await lowBattery.follow(null); // pulled out, or charged
  expect(said()).toEqual([]);
  await lowBattery.follow(18);
  expect(said()).toEqual([]);
  for (const left of [26, 20]) await lowBattery.follow(left);
  expect(said()).toHaveLength(1);
  expect(stop).not.toHaveBeenCalled();
});

it("closes a recording at 10 %, says so, and leaves the next one to the person", async () => {
  await lowBattery.follow(20);
  await lowBattery.follow(10);
  expect(stop).toHaveBeenCalledOnce();
  expect(said()).toEqual([expect.stringContaining("the recording a.pcapng was closed in time and is kept. Values still come")]);
  stores.live.state = state({ file: "b.pcapng" });
  for (const left of [9, null, 8]) await lowBattery.follow(left);
  expect(stop).toHaveBeenCalledOnce();
});

it("tries again while the recording can't be closed", async () => {
  stop.mockRejectedValueOnce(new DOMException("busy", "AbortError"));
  await lowBattery.follow(10);
  expect(said()).toEqual([]);
  await Promise.all([lowBattery.follow(10), lowBattery.follow(10)]);
  expect(stop).toHaveBeenCalledTimes(2);
  expect(said()).toHaveLength(1);
});

it("without a recording it only warns, and one that is begun then goes on", async () => {
  stores.live.state = state(null);
  await lowBattery.follow(9);
  expect(said()).toHaveLength(1);
  stores.live.state = state({ file: "b.pcapng" });
  await lowBattery.follow(9);
  expect(stop).not.toHaveBeenCalled();
});
