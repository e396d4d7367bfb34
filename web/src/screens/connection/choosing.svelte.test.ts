import { flushSync } from "svelte";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Port, State } from "../../lib/api/types";
import { served } from "../../lib/platform/host";
import { connectByItself } from "../../site/byItself.svelte";
import { Stores } from "../../stores";

const CABLE = "webusb:1a86:7523";
const state = (line: string): State =>
  ({ line, port: line === "off" ? null : CABLE, recording: null, rights: "control", controller: null }) as State;
const choosePort = vi.fn<() => Promise<string | null>>();

let phone: Stores;
type Going = ReturnType<Stores["route"]["later"]>;

let there: ReturnType<typeof vi.fn<Going>>;
let connect: ReturnType<typeof vi.spyOn>;
let end: () => void;

beforeEach(() => {
  vi.stubGlobal("document", Object.assign(new EventTarget(), { hidden: false }));
  phone = new Stores({ ...served, choosePort, feedsAdapters: true });
  there = vi.fn<Going>();
  vi.spyOn(phone.route, "later").mockReturnValue(there);
  vi.spyOn(phone.api, "ports").mockResolvedValue({ ports: [] });
  connect = vi.spyOn(phone.api, "connect").mockImplementation(() => Promise.resolve(state("no-port")));
  choosePort.mockReset().mockResolvedValue(CABLE);
  phone.live.link = "open";
  phone.live.state = state("off");
  end = $effect.root(() => phone.connection.follow());
});
afterEach(() => {
  end();
  vi.unstubAllGlobals();
});

function becomes(line: string) {
  phone.live.state = state(line);
  flushSync();
}

it("a cable that was chosen in the browser's list leads to its gauges when the unit answers, once", async () => {
  await phone.connection.choose();
  expect(connect.mock.calls).toEqual([[CABLE]]);
  becomes("no-echo");
  expect(there).not.toHaveBeenCalled();
  becomes("sampling");
  expect(there.mock.calls).toEqual([["live"]]);
  for (const line of ["echo-only", "sampling"]) becomes(line);
  expect(there).toHaveBeenCalledOnce();
});

it("a person who has connected to something else meanwhile is not led away", async () => {
  await phone.connection.choose();
  await phone.connection.connect("webusb:0403:6001");
  becomes("sampling");
  expect(there).not.toHaveBeenCalled();
});

it("without a choice in the browser's list its advice is shown", async () => {
  choosePort.mockResolvedValue(null);
  await phone.connection.choose();
  expect(there.mock.calls).toEqual([["connection"]]);
  expect([phone.connection.choosing, connect.mock.calls.length]).toEqual([false, 0]);
});

it("a list that can't be shown leaves no trace", async () => {
  choosePort.mockRejectedValue(new TypeError("no"));
  await expect(phone.connection.choose()).rejects.toThrow("no");
  expect(phone.connection.choosing).toBe(false);
});

const plugged = (...urls: string[]) => {
  phone.connection.ports.value = urls.map((url) => ({ url, likely: true, chip: "CH340", quirks: [] }) as unknown as Port);
  flushSync();
};

it("on a phone a cable that was allowed before is connected to without a touch, once", () => {
  connectByItself(phone);
  flushSync();
  plugged();
  expect(connect).not.toHaveBeenCalled();
  plugged(CABLE);
  expect(connect.mock.calls).toEqual([[CABLE]]);
  becomes("sampling");
  becomes("off"); // disconnected by the person
  plugged();
  plugged(CABLE);
  expect(connect).toHaveBeenCalledOnce();
});

it("not while the browser's list is shown, nor on a computer", () => {
  phone.connection.choosing = true;
  connectByItself(phone);
  flushSync();
  plugged(CABLE);
  expect(connect).not.toHaveBeenCalled();
  phone.connection.choosing = false;
  flushSync();
  expect(connect).toHaveBeenCalledOnce();
  phone.host.feedsAdapters = false;
  connectByItself(phone);
  plugged(CABLE);
  expect(connect).toHaveBeenCalledOnce();
});
