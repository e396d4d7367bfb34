import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { presets } from "./presets.svelte";

beforeEach(() => void vi.useFakeTimers());

afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

it("the user's presets are loaded although their first request failed", async () => {
  const response = () => new Response(JSON.stringify({ presets: [] }), { headers: { "Content-Type": "application/json" } });
  const lost = () => Promise.reject(new TypeError("Failed to fetch"));
  vi.stubGlobal("fetch", vi.fn().mockImplementationOnce(lost).mockImplementation(async () => response()));
  const stop = presets.load();
  await vi.advanceTimersByTimeAsync(0);
  expect(presets.loaded).toBe(false);
  await vi.advanceTimersByTimeAsync(1000);
  expect(presets.loaded).toBe(true);
  stop();
});
