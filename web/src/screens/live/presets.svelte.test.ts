import { flushSync } from "svelte";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Preset } from "../../lib/api/types";
import { served } from "../../lib/platform/host";
import { Stores } from "../../stores";

const { api, live, presets, subscriptions } = new Stores(served);

beforeEach(() => void vi.useFakeTimers());

afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

it("the user's presets are loaded although their first request failed", async () => {
  const response = () => new Response(JSON.stringify({ presets: [] }), { headers: { "Content-Type": "application/json" } });
  const lost = () => Promise.reject(new TypeError("Failed to fetch"));
  vi.stubGlobal(
    "fetch",
    vi
      .fn()
      .mockImplementationOnce(lost)
      .mockImplementation(async () => response()),
  );
  live.link = "open";
  const stop = $effect.root(() => presets.need());
  flushSync();
  await vi.advanceTimersByTimeAsync(0);
  expect(presets.loaded).toBe(false);
  await vi.advanceTimersByTimeAsync(1000);
  expect(presets.loaded).toBe(true);
  stop();
});

it("saving one keeps those that another page has saved meanwhile", async () => {
  const preset = (id: string, name: string): Preset => ({ id, name: { en: name, ru: name }, shipped: false, tiles: [] });
  vi.spyOn(api, "presets").mockResolvedValue({ presets: [preset("own-1", "Theirs")] });
  const saved = vi.spyOn(api, "savePresets").mockImplementation((presets) => Promise.resolve({ presets }));
  vi.spyOn(subscriptions, "set").mockReturnValue();
  presets.own = [];
  presets.draft = preset("own-1", "Mine");
  await presets.save("Mine");
  expect(saved.mock.lastCall).toEqual([[preset("own-1", "Theirs"), preset("own-2", "Mine")]]);
  expect([presets.chosen?.id, presets.draft]).toEqual(["own-2", null]);
  await presets.remove();
  expect(saved.mock.lastCall).toEqual([[preset("own-1", "Theirs")]]);
  presets.own = [];
});
