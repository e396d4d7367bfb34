import { expect, test, vi } from "vitest";

test("a frame that waits when its page goes is not drawn, and is no error", async () => {
  vi.useFakeTimers();
  const frames: FrameRequestCallback[] = [];
  vi.stubGlobal("document", { hidden: false, addEventListener: () => undefined });
  vi.stubGlobal("requestAnimationFrame", (frame: FrameRequestCallback) => frames.push(frame));
  vi.resetModules();
  const { frameClock } = await import("./frameClock.svelte");
  vi.advanceTimersByTime(1000);
  frameClock.request();
  frames.shift()?.(performance.now());
  expect(frameClock.fast).toBe(1);
  frameClock.request(); // so soon that it waits for a timer
  expect(frames).toEqual([]);
  vi.unstubAllGlobals();
  expect(() => vi.advanceTimersByTime(1000)).not.toThrow();
  expect(frames).toEqual([]);
  vi.useRealTimers();
});
