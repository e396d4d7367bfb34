import { beforeEach, describe, expect, it, vi } from "vitest";
import { IDLE_MS, Program } from "./program";
import type { Port } from "./endpoint";
import type { FromWorker, Role, ToWorker } from "./messages";

/** A worker as the page sees it. */
class FakeWorker implements Port {
  onmessage: Port["onmessage"] = null;
  onerror: Port["onerror"] = null;
  readonly received: ToWorker[] = [];
  terminated = false;

  constructor(readonly role: Role) {}

  postMessage(message: ToWorker): void {
    this.received.push(message);
  }

  terminate(): void {
    this.terminated = true;
  }

  say(...messages: FromWorker[]): void {
    for (const data of messages) this.onmessage?.({ data } as MessageEvent<FromWorker>);
  }

  crash(message: string): void {
    this.onerror?.({ message } as ErrorEvent);
  }

  requests(): Extract<ToWorker, { kind: "request" }>[] {
    return this.received.filter((message) => message.kind === "request");
  }

  /** The request number `at`, once it has come. */
  async request(at = 0): Promise<Extract<ToWorker, { kind: "request" }>> {
    await vi.waitFor(() => expect(this.requests().length).toBeGreaterThan(at));
    return this.requests()[at]!;
  }

  /** Answer a request with this text. */
  async answer(text: string, { at = 0, status = 200, type = "application/json" } = {}): Promise<void> {
    const { id } = await this.request(at);
    this.say({ kind: "head", id, status, headers: [["content-type", type]] }, { kind: "body", id, data: bytes(text) }, { kind: "end", id });
  }
}

const bytes = (text: string): Uint8Array<ArrayBuffer> => new TextEncoder().encode(text);

let workers: FakeWorker[];
let program: Program;
const line = () => workers[0]!;
const reader = async (): Promise<FakeWorker> => {
  await vi.waitFor(() => expect(workers.length).toBe(2));
  return workers[1]!;
};

const make = (role: Role) => {
  workers.push(new FakeWorker(role));
  return workers.at(-1)!;
};

beforeEach(() => {
  workers = [];
  vi.stubGlobal(
    "CloseEvent",
    class extends Event {
      constructor(
        kind: string,
        readonly init: { code: number; reason: string },
      ) {
        super(kind);
      }
      get code() {
        return this.init.code;
      }
    },
  );
  program = new Program(make, Promise.resolve(true));
});

it("a page that is not shown lets the adapters go, once there is a program", () => {
  program.line.release(true);
  line().say({ kind: "ready" });
  program.line.release(true);
  program.line.release(false);
  expect(line().received).toEqual([
    { kind: "release", gone: true },
    { kind: "release", gone: false },
  ]);
});

describe("a request", () => {
  it("waits for the start, and is answered by a Response", async () => {
    const asked = program.fetch("api/plan?x=%20y", {
      method: "PUT",
      headers: { "X-Mikas-Client": "page-1" },
      body: JSON.stringify({ a: "ё" }),
    });
    expect(line().received).toEqual([]);
    line().say({ kind: "ready" });
    const { method, path, headers, body } = await line().request();
    expect([method, path]).toEqual(["PUT", "/api/plan?x=%20y"]);
    expect(Object.fromEntries(headers)).toMatchObject({ "x-mikas-client": "page-1" });
    expect(new TextDecoder().decode(body!)).toBe('{"a":"ё"}');
    await line().answer('{"ok":1}', { status: 409 });
    const response = await asked;
    expect([response.status, response.ok, response.headers.get("content-type")]).toEqual([409, false, "application/json"]);
    expect(await response.json()).toEqual({ ok: 1 });
  });

  it("takes bytes and files as its body", async () => {
    line().say({ kind: "ready" });
    const given = [bytes("abc"), bytes("abc").buffer, new Blob(["a", "bc"])];
    for (const [at, body] of given.entries()) {
      void program.fetch("api/dumps/1/compare", { method: "POST", body });
      expect(new TextDecoder().decode((await line().request(at)).body!)).toBe("abc");
    }
  });

  it("streams its body, part by part", async () => {
    line().say({ kind: "ready" });
    const asked = program.fetch("api/doctor", { method: "POST", body: "{}" });
    const { id } = await line().request();
    line().say({ kind: "head", id, status: 200, headers: [] });
    const parts = (await asked).body!.pipeThrough(new TextDecoderStream()).getReader();
    line().say({ kind: "body", id, data: bytes("one\n") });
    expect((await parts.read()).value).toBe("one\n");
    line().say({ kind: "body", id, data: bytes("two\n") }, { kind: "end", id });
    expect((await parts.read()).value).toBe("two\n");
    expect((await parts.read()).done).toBe(true);
  });

  it("without a body is answered without one", async () => {
    line().say({ kind: "ready" });
    const asked = program.fetch("api/state");
    const { id, body } = await line().request();
    line().say({ kind: "head", id, status: 204, headers: [] }, { kind: "end", id });
    expect([body, (await asked).body]).toEqual([null, null]);
  });

  it("is aborted before the answer, amid it, and not after it", async () => {
    line().say({ kind: "ready" });
    const stop = new AbortController();
    const asked = program.fetch("api/state", { signal: stop.signal });
    await line().request();
    stop.abort();
    await expect(asked).rejects.toMatchObject({ name: "AbortError" });
    const second = new AbortController();
    const streamed = program.fetch("api/state", { signal: second.signal });
    const { id } = await line().request(1);
    line().say({ kind: "head", id, status: 200, headers: [] });
    const reading = (await streamed).text();
    second.abort();
    await expect(reading).rejects.toMatchObject({ name: "AbortError" });
    expect(line().received.filter(({ kind }) => kind === "abort")).toEqual([
      { kind: "abort", id: 1 },
      { kind: "abort", id: 2 },
    ]);
    line().say({ kind: "body", id, data: bytes("late") }, { kind: "end", id });
    await expect(program.fetch("api/state", { signal: second.signal })).rejects.toMatchObject({ name: "AbortError" });
    expect(line().requests().length).toBe(2);
  });

  it("whose reader leaves is told to the program", async () => {
    line().say({ kind: "ready" });
    const asked = program.fetch("api/dumps/1/file");
    const { id } = await line().request();
    line().say({ kind: "head", id, status: 200, headers: [] });
    await (await asked).body!.cancel();
    expect(line().received.at(-1)).toEqual({ kind: "abort", id });
    line().say({ kind: "body", id, data: bytes("late") });
  });

  it("fails as without a network when the program ends, before and amid the answer, and from then on", async () => {
    line().say({ kind: "ready" });
    const [first, second] = [program.fetch("api/state"), program.fetch("api/about")];
    const { id } = await line().request(1);
    line().say({ kind: "head", id, status: 200, headers: [] });
    const reading = (await second).text();
    const ended = vi.fn();
    program.line.onended = ended;
    line().say({ kind: "broken", message: "out of memory" });
    await expect(first).rejects.toThrow(TypeError);
    await expect(reading).rejects.toThrow(TypeError);
    await expect(program.fetch("api/state")).rejects.toThrow(TypeError);
    expect(ended).toHaveBeenCalledExactlyOnceWith("out of memory");
  });

  it("fails when the program can't start", async () => {
    const asked = program.fetch("api/recordings");
    line().crash("no such file");
    await expect(asked).rejects.toThrow("no such file");
    expect(workers.length).toBe(1);
  });
});

describe("a socket", () => {
  const opened = async () => {
    const socket = program.connect("api/live?client=page-1");
    const heard: unknown[] = [];
    socket.onmessage = ({ data }) => void heard.push(data);
    socket.onclose = (event) => void heard.push(event.code);
    line().say({ kind: "ready" });
    await vi.waitFor(() => expect(line().received.length).toBe(1));
    return { heard, id: (line().received[0] as { id: number }).id };
  };

  it("carries messages until it is closed", async () => {
    const { heard, id } = await opened();
    expect(line().received).toEqual([{ kind: "open", id, path: "/api/live?client=page-1" }]);
    line().say({ kind: "opened", id }, { kind: "message", id, data: "{}" });
    line().say({ kind: "closed", id, code: 1000, reason: "" }, { kind: "message", id, data: "late" });
    expect(heard).toEqual(["{}", 1000]);
  });

  it("is lost with the program, and at once when there is none", async () => {
    const { heard, id } = await opened();
    line().say({ kind: "opened", id });
    line().crash("an error that the worker survives");
    expect(heard).toEqual([]);
    line().say({ kind: "broken", message: "out of memory" });
    expect(heard).toEqual([1006]);
    const late = program.connect("api/live");
    const closed = vi.fn();
    late.onclose = closed;
    await vi.waitFor(() => expect(closed).toHaveBeenCalledOnce());
  });
});

describe("the reader", () => {
  it("is started when it is first needed, after the line's worker, and knows what that does", async () => {
    program.follow({ recording: "a.pcapng", catalog: "1" });
    const asked = program.fetch("api/recordings");
    await Promise.resolve();
    expect(workers.length).toBe(1);
    line().say({ kind: "ready" });
    (await reader()).say({ kind: "ready" });
    await (await reader()).answer("[]");
    expect(await (await asked).json()).toEqual([]);
    program.follow({ recording: null, catalog: "2" });
    await vi.waitFor(async () =>
      expect((await reader()).received.filter(({ kind }) => kind === "situation")).toEqual([
        { kind: "situation", recording: "a.pcapng", catalog: "1" },
        { kind: "situation", recording: null, catalog: "2" },
      ]),
    );
    expect((await reader()).received[0]!.kind).toBe("situation");
    expect(line().requests()).toEqual([]);
  });

  it("is not waited for while the line is free", async () => {
    line().say({ kind: "ready" });
    program.lineIsFree = true;
    const asked = program.fetch("api/recordings");
    await line().answer("[]");
    expect(await (await asked).json()).toEqual([]);
    (await reader()).say({ kind: "ready" });
    void program.fetch("api/recordings");
    await (await reader()).request();
    expect(line().requests().length).toBe(1);
  });

  it("can be started before it is needed", async () => {
    line().say({ kind: "ready" });
    program.prepareReader();
    expect((await reader()).requests()).toEqual([]);
  });

  it("is done without where it can't be had", async () => {
    line().say({ kind: "ready" });
    const asked = program.fetch("api/recordings");
    (await reader()).say({ kind: "broken", message: "no memory" });
    await line().answer("[]");
    expect(await (await asked).json()).toEqual([]);
    void program.fetch("api/recordings/a");
    await line().request(1);
    expect(workers.length).toBe(2);
  });

  it("is not asked for recordings that are in the memory of the line's worker", async () => {
    workers = [];
    program = new Program(make, Promise.resolve(false));
    line().say({ kind: "ready" });
    const asked = program.fetch("api/recordings");
    await line().answer("[]");
    expect(await (await asked).json()).toEqual([]);
    expect(workers.length).toBe(1);
  });

  it("that ends amid its work does not take the line's worker along, and is started again", async () => {
    line().say({ kind: "ready" });
    const asked = program.fetch("api/recordings/a/rows");
    (await reader()).say({ kind: "ready" });
    await (await reader()).request();
    (await reader()).say({ kind: "broken", message: "out of memory" });
    const response = await asked;
    expect([response.status, (await response.json()).error.code]).toEqual([500, "ReaderEnded"]);
    void program.fetch("api/recordings/a/rows");
    await vi.waitFor(() => expect(workers.map(({ role }) => role)).toEqual(["line", "reader", "reader"]));
    expect(line().requests()).toEqual([]);
    expect(workers.map(({ terminated }) => terminated)).toEqual([false, true, false]);
  });

  it("ends with the line's worker when another tab takes over", async () => {
    line().say({ kind: "ready" });
    void program.fetch("api/recordings").catch(() => undefined);
    await reader();
    program.terminate();
    expect(workers.map(({ terminated }) => terminated)).toEqual([true, true]);
  });
});

describe("where memory is scarce, the reader", () => {
  beforeEach(() => {
    workers = [];
    program = new Program(make, Promise.resolve(true), true);
    line().say({ kind: "ready" });
  });

  it("is not started beforehand, nor for the list while the line is free", async () => {
    program.prepareReader();
    program.lineIsFree = true;
    const listed = program.fetch("api/recordings");
    await line().answer("[]");
    expect(await (await listed).json()).toEqual([]);
    expect(workers.length).toBe(1);
    program.lineIsFree = false;
    void program.fetch("api/recordings");
    (await reader()).say({ kind: "ready" });
    await (await reader()).request();
    expect(line().requests().length).toBe(1);
  });

  it("reads a recording even while the line is free: what the line's worker once needs stays its own", async () => {
    program.lineIsFree = true;
    void program.fetch("api/recordings/a");
    (await reader()).say({ kind: "ready" });
    await (await reader()).request();
    expect(line().requests()).toEqual([]);
  });

  it("ends a minute after its last answer is whole, and is started again", async () => {
    const asked = program.fetch("api/recordings/a/file");
    (await reader()).say({ kind: "ready" });
    const { id } = await (await reader()).request();
    vi.useFakeTimers();
    (await reader()).say({ kind: "head", id, status: 200, headers: [] });
    const body = (await asked).text();
    await vi.advanceTimersByTimeAsync(3 * IDLE_MS); // the file still comes
    expect(workers[1]!.terminated).toBe(false);
    workers[1]!.say({ kind: "end", id });
    await body;
    await vi.advanceTimersByTimeAsync(IDLE_MS - 1);
    expect(workers[1]!.terminated).toBe(false);
    await vi.advanceTimersByTimeAsync(1);
    expect(workers.map(({ terminated }) => terminated)).toEqual([false, true]);
    vi.useRealTimers();
    const again = program.fetch("api/recordings/a");
    await vi.waitFor(() => expect(workers.length).toBe(3));
    workers[2]!.say({ kind: "ready" });
    await workers[2]!.answer("{}");
    expect(await (await again).json()).toEqual({});
  });

  it("stays where memory is not scarce, and while one request follows another", async () => {
    const asked = async (at: number) => {
      const answer = program.fetch("api/recordings/a");
      await vi.advanceTimersByTimeAsync(1);
      workers[1]!.say({ kind: "ready" });
      await workers[1]!.answer("{}", { at });
      await (await answer).text();
    };
    vi.useFakeTimers();
    for (const at of [0, 1, 2]) {
      await asked(at);
      await vi.advanceTimersByTimeAsync(IDLE_MS - 1000);
    }
    expect(workers[1]!.terminated).toBe(false);
    workers = [];
    program = new Program(make, Promise.resolve(true));
    line().say({ kind: "ready" });
    await asked(0);
    await vi.advanceTimersByTimeAsync(3 * IDLE_MS);
    expect(workers[1]!.terminated).toBe(false);
    vi.useRealTimers();
  });
});
