// A browser that hangs: it keeps no promise. Each wait ends, and says so.
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { keepsFiles } from "./boot/keepsFiles";
import { loadAnew } from "./offline/anew";
import { KeptFiles } from "./offline/keptFiles";
import type { Folder } from "./storage/folder";
import { inTime } from "./storage/inTime";
import { Pool } from "./storage/pool";
import { OneTab } from "./tabs/oneTab";
import { HANGS } from "./within";

const site = new URL("https://host.example/mikas/");
const never = () => new Promise<never>(() => undefined);
const failure = (promise: Promise<unknown>) => promise.then(() => null).catch((error: unknown) => error);

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const later = () => vi.advanceTimersByTimeAsync(120_000);

it("the kept files are not opened for ever", async () => {
  const folder: Folder = { names: never, open: never, view: never };
  const opened = failure(inTime(Pool.open(folder)));
  await later();
  expect(await opened).toMatchObject({ name: "StorageError", reason: "hangs" });
});

it("the page takes a browser that does not say so for one that keeps no files", async () => {
  vi.stubGlobal("navigator", { storage: { getDirectory: never } });
  const keeps = keepsFiles();
  await later();
  expect(await keeps).toBe(false);
});

it("a lock that the browser neither gives nor refuses ends the start", async () => {
  const tab = new OneTab({ request: never } as unknown as LockManager, { postMessage: vi.fn(), onmessage: null });
  const elsewhere = vi.fn();
  const became = failure(tab.become({ refusal: () => null, leave: vi.fn(), restart: vi.fn() }, elsewhere));
  await later();
  expect(await became).toMatchObject({ name: HANGS });
  expect(elsewhere).not.toHaveBeenCalled();
});

it("a kept file that is not found is asked of the server", async () => {
  const kept = new KeptFiles("1", site, { match: never } as unknown as CacheStorage, fetch);
  const found = kept.find(`${site.href}index.html`);
  await later();
  expect(await found).toBeUndefined();
});

it("the page is loaded anew though the browser forgets nothing, and not without its server", async () => {
  const hanging = { caches: { keys: never } as unknown as CacheStorage, workers: { getRegistrations: never } };
  const reload = vi.fn();
  const done = loadAnew(site, { ...hanging, reload, fetch: async () => new Response() });
  await later();
  expect([await done, reload.mock.calls.length]).toEqual([true, 1]);
  const alone = loadAnew(site, { ...hanging, reload, fetch: never });
  await later();
  expect([await alone, reload.mock.calls.length]).toEqual([false, 1]);
});
