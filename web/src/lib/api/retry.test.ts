import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { retry } from "./retry";
import { served } from "../platform/host";
import { Stores } from "../../stores";

const { catalog } = new Stores(served);

beforeEach(() => void vi.useFakeTimers());

afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

/** A job that fails so many times, and the seconds at which it ran. */
function failing(times: number) {
  const asked: number[] = [];
  const began = Date.now();
  const job = async () => {
    asked.push((Date.now() - began) / 1000);
    if (asked.length <= times) throw new Error("no answer");
  };
  return { asked, job };
}

describe("retry", () => {
  it("repeats after 1, 2, 4, 8 s until the job succeeds", async () => {
    const { asked, job } = failing(5);
    retry(job);
    await vi.advanceTimersByTimeAsync(120_000);
    expect(asked).toEqual([0, 1, 3, 7, 15, 23]);
  });

  it("waits for the response before it repeats", async () => {
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

  it("does not repeat after it was stopped, even while a job is running", async () => {
    const { asked, job } = failing(Infinity);
    const stop = retry(job);
    stop();
    await vi.advanceTimersByTimeAsync(60_000);
    expect(asked).toEqual([0]);
  });
});

describe("the catalog", () => {
  const answer = (body: unknown) => new Response(JSON.stringify(body), { headers: { "Content-Type": "application/json" } });
  const lost = () => Promise.reject(new TypeError("Failed to fetch"));

  it("is loaded although its first request failed", async () => {
    const got = { parameters: [], derived: [], presets: [] };
    vi.stubGlobal(
      "fetch",
      vi
        .fn()
        .mockImplementationOnce(lost)
        .mockImplementation(async () => answer(got)),
    );
    const stop = catalog.follow("1")!;
    await vi.advanceTimersByTimeAsync(0);
    expect(catalog.loaded).toBeNull();
    await vi.advanceTimersByTimeAsync(1000);
    expect(catalog.loaded).toEqual(got);
    stop();
  });
});
