import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { FakePort, opened, python } from "../../../test/serialRig";
import { Heard } from "./ahead";
import { now } from "./serial";

const REQUEST = [0x61, 0x1a, 0x85, 0x0d];
const frame = (...body: number[]) => {
  const stuffed = [...body, -body.reduce((sum, it) => sum + it, 0) & 0xff].flatMap((it) =>
    it === 0x0d ? [0x40, 0xcd] : it === 0x40 ? [0x40, 0x00] : it,
  );
  return [...stuffed, 0x0d];
};

/** Whether these bytes, in chunks, are an answer to `REQUEST` of `length` bytes. */
function isAnswer(length: number, ...chunks: number[][]): boolean {
  const heard = new Heard();
  heard.begin([]);
  for (const chunk of chunks) heard.add(new Uint8Array(chunk));
  return heard.isAnswer(new Uint8Array(REQUEST), length);
}

describe("an answer", () => {
  it("is the echo and a frame of the right length, however it came", () => {
    const whole = [...REQUEST, ...frame(0x5a)];
    expect(isAnswer(1, whole)).toBe(true);
    expect(isAnswer(1, ...whole.map((it) => [it]))).toBe(true);
    expect(isAnswer(0, REQUEST, frame())).toBe(true);
    expect(isAnswer(255, REQUEST, frame(...Array.from({ length: 255 }, (_, at) => at)))).toBe(true);
  });

  it("is not whole before its last byte", () => {
    const whole = [...REQUEST, ...frame(0x0d, 0x40, 0x00)];
    for (let end = 0; end < whole.length; end += 1) expect(isAnswer(3, whole.slice(0, end)), `${end}`).toBe(false);
    expect(isAnswer(3, whole)).toBe(true);
  });

  it("may have a stuffed checksum", () => {
    expect(frame(0xf3)).toEqual([0xf3, 0x40, 0xcd, 0x0d]);
    expect(isAnswer(1, REQUEST, frame(0xf3))).toBe(true);
    expect(isAnswer(1, REQUEST, frame(0xc0))).toBe(true);
  });

  it("has its own length: a refusal, or another's response, has not", () => {
    expect(isAnswer(2, REQUEST, frame(0x01))).toBe(false);
    expect(isAnswer(1, REQUEST, frame(0x01, 0x02))).toBe(false);
  });

  it.each([
    ["a damaged echo", [0x61, 0x1b, 0x85, 0x0d], frame(0x5a)],
    ["no echo", frame(0x5a)],
    ["a byte before the echo", [0x00], REQUEST, frame(0x5a)],
    ["a wrong checksum", REQUEST, [0x5a, 0xa7, 0x0d]],
    ["a byte behind it", REQUEST, frame(0x5a), [0x00]],
    ["a second response", REQUEST, frame(0x5a), frame(0x5a)],
    ["a bare terminator before it (D5)", REQUEST, [0x0d], frame(0x5a)],
    ["a raw checksum 0D (D3)", REQUEST, [0xf3, 0x0d, 0x0d]],
    ["a raw checksum 40 (D3)", REQUEST, [0xc0, 0x40, 0x0d]],
    ["an irregular escape (D4)", REQUEST, [0x40, 0x01, 0xbf, 0x0d]],
  ] as [string, ...number[][]][])("is not %s", (_, ...chunks) => {
    expect(isAnswer(1, ...chunks)).toBe(false);
  });

  it("is no stream, whatever came of it", () => {
    const many = Array.from({ length: 1000 }, () => frame(0x5a));
    expect(isAnswer(1, REQUEST, ...many)).toBe(false);
  });

  it("follows the latest request, and nothing that came before it", () => {
    const heard = new Heard();
    const before = new Uint8Array([0x00]);
    heard.begin([before]);
    heard.add(new Uint8Array([...REQUEST, ...frame(0x5a)]));
    expect(heard.isAnswer(new Uint8Array(REQUEST), 1)).toBe(false);
    heard.begin([]);
    heard.add(new Uint8Array([...REQUEST, ...frame(0x5a)]));
    expect(heard.isAnswer(new Uint8Array(REQUEST), 1)).toBe(true);
  });
});

describe("a request that follows an answer", () => {
  const ask = [0x61, 0x1a, 0x85, 0x0d];
  const answer = [0x5a, 0xa6, 0x0d];
  const next = [0x61, 0x1c, 0x83, 0x0d];

  async function asked() {
    const port = new FakePort();
    const it = await opened(port);
    await it.write(python(...ask), 1).promise;
    it.writeAfter(python(...ask), 1, python(...next), 1);
    const came = async (...bytes: number[]) => {
      port.send(...bytes);
      await vi.advanceTimersByTimeAsync(2);
    };
    return { port, it, came };
  }

  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => void vi.useRealTimers());

  it("is written at its last byte, with the time of it, and what comes then waits", async () => {
    const { port, it, came } = await asked();
    await came(...ask);
    await came(...answer.slice(0, 2));
    expect(port.written).toEqual(ask);
    port.send(answer[2]!);
    await vi.advanceTimersByTimeAsync(0);
    const at = now();
    expect(port.written).toEqual([...ask, ...next]);
    await vi.advanceTimersByTimeAsync(2);
    await came(...next.slice(0, 2));
    expect([...it.take()!]).toEqual([...ask, ...answer]);
    expect(it.takenAt).toBeCloseTo(at, 4);
    expect(it.take()).toBeUndefined();
    await came(...next.slice(2));
    expect(it.takeBack()).toBeCloseTo(at, 4);
    expect([...it.take()!]).toEqual(next);
    expect(it.takenAt).toBeGreaterThan(at + 0.003);
  });

  it("is written at once where the answer is there", async () => {
    const port = new FakePort();
    const it = await opened(port);
    await it.write(python(...ask), 1).promise;
    port.send(...ask, ...answer);
    await vi.advanceTimersByTimeAsync(2);
    it.writeAfter(python(...ask), 1, python(...next), 1);
    await vi.advanceTimersByTimeAsync(2);
    expect(port.written).toEqual([...ask, ...next]);
    expect(it.takeBack()).toBeGreaterThan(0);
  });

  it("follows a request that was itself written so", async () => {
    const { port, it, came } = await asked();
    await came(...ask, ...answer);
    it.take();
    it.takeBack();
    it.writeAfter(python(...next), 1, python(...ask), 1);
    await came(...next);
    expect(port.written).toEqual([...ask, ...next]);
    await came(...answer);
    expect(port.written).toEqual([...ask, ...next, ...ask]);
  });

  it("is not written after anything else", async () => {
    for (const bytes of [
      [...ask, 0x01, 0xfe, 0x0d].with(1, 0),
      [...ask, 0x5a, 0xa7, 0x0d],
      [...ask, ...answer, 0],
      [...ask, 1, 2, 0xfd, 0x0d],
    ]) {
      const { port, it, came } = await asked();
      await came(...bytes);
      expect(port.written).toEqual(ask);
      expect([...it.take()!]).toEqual(bytes);
      expect(it.takeBack()).toBe(0);
    }
  });

  it("is not written once it is taken back, or another is", async () => {
    const { port, it, came } = await asked();
    expect(it.takeBack()).toBe(0);
    await came(...ask, ...answer);
    expect(port.written).toEqual(ask);
    const other = await asked();
    await other.it.write(python(1, 0xff, 0x0d), 1).promise;
    await other.came(...ask, ...answer);
    expect(other.port.written).toEqual([...ask, 1, 0xff, 0x0d]);
    expect(other.it.takeBack()).toBe(0);
  });

  it("is not written where bytes came before the request: Python judges them first", async () => {
    const port = new FakePort();
    const it = await opened(port);
    port.send(0);
    await vi.advanceTimersByTimeAsync(2);
    await it.write(python(...ask), 1).promise;
    it.writeAfter(python(...ask), 1, python(...next), 1);
    port.send(...ask, ...answer);
    await vi.advanceTimersByTimeAsync(2);
    expect(port.written).toEqual(ask);
    expect([...it.take()!]).toEqual([0, ...ask, ...answer]);
  });

  it("ends in a loss when the port takes none", async () => {
    const { port, it, came } = await asked();
    port.takes = new Promise(() => undefined);
    await came(...ask, ...answer);
    await vi.advanceTimersByTimeAsync(1100);
    expect(it.lost).toBe("stuck");
  });
});
