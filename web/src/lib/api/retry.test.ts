import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { presets } from "../../screens/live/presets.svelte";
import { catalog } from "./catalog.svelte";
import { retry } from "./retry";

beforeEach(() => void vi.useFakeTimers());

afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

/** A job that fails so often, and when it was asked. */
function failing(times: number) {
  const asked: number[] = [];
  const began = Date.now();
  const job = async () => {
    asked.push((Date.now() - began) / 1000);
    if (asked.length <= times) throw new Error("no answer");
  };
  return { asked, job };
}

describe("insisting", () => {
  it("asks again after 1, 2, 4, 8 s, and no more once it came", async () => {
    const { asked, job } = failing(5);
    retry(job);
    await vi.advanceTimersByTimeAsync(120_000);
    expect(asked).toEqual([0, 1, 3, 7, 15, 23]);
  });

  it("waits for an answer before it asks again", async () => {
    let asked = 0;
    let fail = (_: Error) => {};
    retry(() => {
      asked += 1;
      return new Promise((_, reject) => (fail = reject));
    });
    await vi.advanceTimersByTimeAsync(60_000);
    expect(asked).toBe(1);
    fail(new Error("no answer"));
    await vi.advanceTimersByTimeAsync(1000);
    expect(asked).toBe(2);
  });

  it("ends with the line: not even what is on its way is asked again", async () => {
    const { asked, job } = failing(Infinity);
    const stop = retry(job);
    stop();
    await vi.advanceTimersByTimeAsync(60_000);
    expect(asked).toEqual([0]);
  });
});

describe("what the page can't do without", () => {
  const answer = (body: unknown) => new Response(JSON.stringify(body), { headers: { "Content-Type": "application/json" } });
  const lost = () => Promise.reject(new TypeError("Failed to fetch"));

  it("the catalog comes although its first request was lost", async () => {
    const got = { parameters: [], derived: [], presets: [] };
    vi.stubGlobal("fetch", vi.fn().mockImplementationOnce(lost).mockImplementation(async () => answer(got)));
    const stop = catalog.load();
    await vi.advanceTimersByTimeAsync(0);
    expect(catalog.loaded).toBeNull();
    await vi.advanceTimersByTimeAsync(1000);
    expect(catalog.loaded).toEqual(got);
    stop();
  });

  it("so do the presets", async () => {
    vi.stubGlobal("fetch", vi.fn().mockImplementationOnce(lost).mockImplementation(async () => answer({ presets: [] })));
    const stop = presets.load();
    await vi.advanceTimersByTimeAsync(0);
    expect(presets.loaded).toBe(false);
    await vi.advanceTimersByTimeAsync(1000);
    expect(presets.loaded).toBe(true);
    stop();
  });
});
