import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { History, State } from "../api/types";
import { served, type LiveSocket } from "../platform/host";
import { Stores } from "../../stores";

const { api, live } = new Stores(served);

const history = (value: number) => ({ names: ["A"], times: [1, 2], values: [[value, value]], events: [], later: 0 }) as unknown as History;

afterEach(() => {
  live.columns.clear();
  live.extremes.clear();
  live.extremesFrom = null;
});

it("a channel that is changed while the history is loaded has the values of the change, and no others", async () => {
  const answers: ((history: History) => void)[] = [];
  vi.spyOn(api, "history").mockImplementation(() => new Promise((resolve) => void answers.push(resolve)));
  const answer = async (value: number) => {
    const { length } = answers;
    answers.at(-1)!(history(value));
    await vi.waitFor(() => expect(answers.length).toBe(length + 1));
  };
  live.reload(["A"]);
  await answer(1);
  live.reload(["A"]);
  await answer(1);
  await answer(5);
  answers.at(-1)!(history(5));
  await vi.waitFor(() => expect([...(live.columns.column("A") ?? [])]).toEqual([5, 5]));
  expect(live.extremes.get("A")).toEqual({ min: 5, max: 5 });
});

it("moves all that it holds when the program's date is set", async () => {
  const sockets: LiveSocket[] = [];
  const connect = () => {
    sockets.push({ onmessage: null, onclose: null, close: () => undefined });
    return sockets.at(-1)!;
  };
  vi.stubGlobal("document", { addEventListener: () => undefined, hidden: false });
  vi.stubGlobal("requestAnimationFrame", () => 0);
  vi.stubGlobal("window", { addEventListener: () => undefined });
  vi.stubGlobal("setInterval", () => 0);
  const stores = new Stores({ ...served, connect, fetch: () => Promise.reject(new TypeError("no network")) });
  stores.live.start();
  const say = (message: object) => sockets[0]!.onmessage!({ data: JSON.stringify({ now: 5, dropped: 0, ...message }) } as MessageEvent);
  const data = (...times: number[]) => ({ names: ["A"], times, values: [times] });
  const gap = { kind: "gap", time: 3, began: 2, ended: 3, reason: null };
  say({ later: 0, data: data(1, 4), events: [gap] });
  await vi.waitFor(() => expect(stores.live.columns.length).toBe(2));
  stores.display.live.toggle();
  say({ now: 1006, later: 1000, data: data(1006) });
  expect([...stores.live.columns.times()]).toEqual([1001, 1004, 1006]);
  expect([...stores.live.columns.column("A")!]).toEqual([1, 4, 1006]);
  expect(stores.live.events).toEqual([{ ...gap, time: 1003, began: 1002, ended: 1003 }]);
  expect([stores.live.extremesFrom, stores.live.latest.get("A")?.time]).toEqual([1001, 1006]);
  expect(Math.round(stores.display.live.now())).toBe(1005);
  say({ now: 6, later: 0, data: data(7) });
  expect([...stores.live.columns.times()]).toEqual([1, 4, 6, 7]);
  vi.unstubAllGlobals();
});

it("values, minima and maxima end with the unit that they are of", async () => {
  const sockets: LiveSocket[] = [];
  const connect = () => {
    sockets.push({ onmessage: null, onclose: null, close: () => undefined });
    return sockets.at(-1)!;
  };
  vi.stubGlobal("document", { addEventListener: () => undefined, hidden: false });
  vi.stubGlobal("requestAnimationFrame", () => 0);
  vi.stubGlobal("window", { addEventListener: () => undefined });
  vi.stubGlobal("setInterval", () => 0);
  const { live, display } = new Stores({ ...served, connect, fetch: () => Promise.reject(new TypeError("no network")) });
  live.start();
  const say = (message: object) => sockets[0]!.onmessage!({ data: JSON.stringify({ now: 5, dropped: 0, ...message }) } as MessageEvent);
  const data = (names: string[], ...times: number[]) => ({ names, times, values: names.map(() => times) });
  say({ later: 0, data: data(["A", "B"], 1, 4) });
  await vi.waitFor(() => expect(live.columns.length).toBe(2));
  const found = { kind: "unit", time: 4.5, another: true };
  say({ events: [{ ...found, time: 2, another: false }] });
  expect(live.extremes.get("A")).toEqual({ min: 1, max: 4 });
  say({ events: [found], data: data(["A"], 4.2, 5, 6) });
  expect(live.extremes.get("A")).toEqual({ min: 5, max: 6 });
  expect([live.extremes.get("B"), live.latest.get("B"), live.latest.get("A")?.value]).toEqual([undefined, undefined, 6]);
  expect([live.extremesFrom, display.source.since]).toEqual([5, 4.5]);
  // Found out later, when the history came: the values since then still count.
  say({ events: [{ ...found, time: 5.5 }] });
  expect([live.extremes.get("A"), live.extremesFrom]).toEqual([{ min: 6, max: 6 }, 6]);
  vi.unstubAllGlobals();
});

describe("a socket that brings nothing", () => {
  /** A live connection whose sockets the test holds; none closes by itself. */
  function connection(patience = served.patience, fetch: typeof served.fetch = () => Promise.reject(new TypeError("no network"))) {
    const sockets: (LiveSocket & { closed: boolean })[] = [];
    const connect = () => {
      const socket = {
        onmessage: null,
        onclose: null,
        closed: false,
        close: () => void (socket.closed = true),
      } as (typeof sockets)[number];
      sockets.push(socket);
      return socket;
    };
    const stores = new Stores({ ...served, connect, patience, fetch });
    stores.live.start();
    const state = { line: "sampling", port: "A", alarms: [], rights: "control", controller: null } as unknown as State;
    const say = () => sockets.at(-1)!.onmessage!({ data: JSON.stringify({ now: 1, dropped: 0, state }) } as MessageEvent);
    return { live: stores.live, api: stores.api, say, sockets };
  }

  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("document", { addEventListener: () => undefined, hidden: false });
    vi.stubGlobal("requestAnimationFrame", () => 0);
    vi.stubGlobal("window", { addEventListener: () => undefined });
  });
  afterEach(() => {
    vi.clearAllTimers();
    vi.unstubAllGlobals();
    vi.useRealTimers();
  });

  it("is lost within 3 s, though nothing closes it, and another one is opened", () => {
    const { live, say, sockets } = connection();
    say();
    for (let second = 0; second < 10; second += 1) {
      vi.advanceTimersByTime(2000);
      say();
    }
    expect([live.link, live.answers, sockets.length]).toEqual(["open", true, 1]);
    vi.advanceTimersByTime(3000);
    expect([live.link, live.answers, sockets[0]!.closed]).toEqual(["lost", false, true]);
    vi.advanceTimersByTime(500);
    expect(sockets.length).toBe(2);
    say();
    expect([live.link, live.answers]).toEqual(["open", true]);
  });
  it("has a little longer to be opened, again and again: 5 s after a network has come back it is there", () => {
    const { live, say, sockets } = connection();
    say();
    vi.advanceTimersByTime(200_000);
    const opened = sockets.length;
    expect(live.link).toBe("lost");
    vi.advanceTimersByTime(5000);
    expect(sockets.length).toBeGreaterThan(opened);
    say();
    expect(live.link).toBe("open");
  });
  it("is not lost by a page that did not run: it has not looked", () => {
    const { live, say } = connection();
    say();
    vi.advanceTimersByTime(2000);
    vi.setSystemTime(Date.now() + 3_600_000); // the page slept: no timer ran
    vi.advanceTimersByTime(500);
    expect(live.link).toBe("open");
  });
  it("takes the requests along that have no answer, and the history is asked for again", async () => {
    const asked: { path: string; answer: (response: Response) => void; signal: AbortSignal }[] = [];
    const { live, api, say } = connection(
      served.patience,
      (path, init) =>
        new Promise((answer, fail) => {
          const signal = init!.signal!;
          asked.push({ path, answer, signal });

          signal.addEventListener("abort", () => fail(signal.reason));
        }),
    );
    say();
    const pressed = api.startRecording().then(
      () => "answered",
      (error: Error) => error.name,
    );
    await vi.advanceTimersByTimeAsync(4000); // lost, and open again
    say();
    await vi.advanceTimersByTimeAsync(0);
    expect(asked.map(({ path, signal }) => [path.split("?")[0], signal.aborted])).toEqual([
      ["api/history", true],
      ["api/recording/start", false],
      ["api/history", false],
    ]);
    asked[2]!.answer(Response.json(history(7)));
    await vi.advanceTimersByTimeAsync(0);
    asked[3]!.answer(Response.json(history(7))); // the last minute
    for (let second = 0; second < 15; second += 1) {
      await vi.advanceTimersByTimeAsync(1000);
      say();
    }
    expect(await pressed).toBe("ApiError");
    expect([live.link, [...live.columns.column("A")!]]).toEqual(["open", [7, 7]]);
  });
  it("in the page without installation starts as long as it takes", () => {
    const { live, say } = connection({ first: Infinity, next: 15_000 });
    vi.advanceTimersByTime(120_000);
    expect(live.link).toBe("connecting");
    say();
    vi.advanceTimersByTime(14_000);
    expect(live.link).toBe("open");
    vi.advanceTimersByTime(1000);
    expect(live.link).toBe("lost");
  });
});
