import { flushSync } from "svelte";
import { afterEach, expect, it, vi } from "vitest";
import { served } from "../platform/host";
import { Stores } from "../../stores";
import type { Catalog, State } from "./types";

afterEach(() => void vi.useRealTimers());

const version = (version: string) => ({ version, parameters: [], derived: [], presets: [] }) as unknown as Catalog;
const state = (catalog: string) => ({ catalog, line: "off" }) as State;

/** A page that follows the catalog of its program. */
function page(stores: Stores) {
  const end = $effect.root(() => stores.catalog.follow());
  const says = (catalog: string) => {
    stores.live.link = "open";
    stores.live.state = state(catalog);
    flushSync();
  };
  return { end, says };
}

it("a catalog that was requested before a change does not replace the changed one", async () => {
  const stores = new Stores(served);
  let answer = (_: Catalog) => {};
  vi.spyOn(stores.api, "catalog").mockImplementation(() => new Promise((resolve) => (answer = resolve)));
  const { end, says } = page(stores);
  says("1");
  stores.catalog.use(version("2")); // saved on this page
  says("2");
  answer(version("1"));
  await Promise.resolve();
  await Promise.resolve();
  expect(stores.catalog.loaded?.version).toBe("2");
  end();
});

it("the catalog is loaded although its first request failed", async () => {
  vi.useFakeTimers();
  const got = version("1");
  const fetch = vi
    .fn()
    .mockRejectedValueOnce(new TypeError("Failed to fetch"))
    .mockResolvedValue(new Response(JSON.stringify(got)));
  const stores = new Stores({ ...served, fetch });
  const { end, says } = page(stores);
  says("1");
  await vi.advanceTimersByTimeAsync(0);
  expect(stores.catalog.loaded).toBeNull();
  await vi.advanceTimersByTimeAsync(1000);
  expect(stores.catalog.loaded).toEqual(got);
  end();
});
