import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { LiveMessage, State } from "./lib/api/types";
import { served, type LiveSocket } from "./lib/platform/host";
import { Stores } from "./stores";

/** A page over a program of its own: what it has asked, and what the program says on its socket. */
function page(line: State["line"], port: string) {
  const asked: string[] = [];
  const socket: LiveSocket = { onmessage: null, onclose: null, close: () => undefined };
  const stores = new Stores({
    ...served,
    connect: () => socket,
    patience: { first: Infinity, next: Infinity },
    fetch: (address) => {
      asked.push(address);
      return Promise.resolve(new Response(JSON.stringify({ names: [], times: [], values: [], events: [], ports: [{ url: port }] })));
    },
  });
  stores.live.start();
  const state = { line, port, alarms: [], rights: "control", controller: { you: port === "A" }, plan: { wanted: [], first: [] } };
  const say = (message: Partial<LiveMessage>) =>
    socket.onmessage!.call({} as WebSocket, { data: JSON.stringify({ now: 100, dropped: 0, ...message }) } as MessageEvent);
  const begin = () => say({ state: state as unknown as State });
  return { asked, begin, say, socket, stores };
}

beforeEach(() => {
  vi.stubGlobal("document", { addEventListener: () => undefined, hidden: true });
  vi.stubGlobal("window", { addEventListener: () => undefined });
});

afterEach(() => void vi.unstubAllGlobals());

it("two pages in one window have each its own connection, values, recordings and messages", async () => {
  const [one, other] = [page("sampling", "A"), page("ecu-alive", "B")];
  one.begin();
  expect([one.stores.live.link, other.stores.live.link]).toEqual(["open", "connecting"]);
  other.begin();
  one.say({ data: { names: ["FREQ"], times: [99], values: [[800]] } });
  other.say({ data: { names: ["FREQ"], times: [99], values: [[3000]] } });
  expect([one, other].map(({ stores }) => stores.display.value("FREQ"))).toEqual([
    { kind: "stale", value: 800, age: expect.closeTo(1, 1) },
    { kind: "none" },
  ]);
  expect([one, other].map(({ stores }) => stores.live.latest.get("FREQ")?.value)).toEqual([800, 3000]);
  expect([one, other].map(({ stores }) => [stores.live.answers, stores.control.mine, stores.live.unit.includes('"A"')])).toEqual([
    [true, true, true],
    [true, false, false],
  ]);

  one.stores.toasts.refuse(() => "no");
  one.stores.cursors.a = 5;
  one.stores.channelCard.open("FREQ");
  expect([other.stores.toasts.shown, other.stores.cursors.a, other.stores.channelCard.name]).toEqual([[], null, null]);

  await other.stores.connection.ports.reload();
  expect(other.stores.connection.ports.value).toEqual([{ url: "B" }]);
  expect([one.stores.connection.ports.value, one.asked.includes("api/ports")]).toEqual([null, false]);

  one.socket.onclose!.call({} as WebSocket, {} as CloseEvent);
  expect([one.stores.live.link, other.stores.live.link]).toEqual(["lost", "open"]);
});
