import { expect, it, vi } from "vitest";
import { loadAnew } from "./anew";

const site = new URL("https://host.example/mikas/");

function browser(answer: () => Promise<Response>) {
  const kept = new Set(["mikas /mikas/ 1", "mikas /mikas/ 2", "mikas /other/ 1", "somebody's"]);
  const registrations = [site.href, "https://host.example/other/"].map((scope) => ({ scope, unregister: vi.fn() }));
  const caches = { keys: async () => [...kept], delete: async (name: string) => kept.delete(name) } as unknown as CacheStorage;
  const workers = { getRegistrations: async () => registrations as unknown as ServiceWorkerRegistration[] };
  return { kept, registrations, reload: vi.fn(), fetch: vi.fn(answer), caches, workers };
}

it("what is kept of this site is forgotten, and nothing of others", async () => {
  const it = browser(async () => new Response());
  expect(await loadAnew(site, it)).toBe(true);
  expect([...it.kept]).toEqual(["mikas /other/ 1", "somebody's"]);
  expect(it.registrations.map(({ unregister }) => unregister.mock.calls.length)).toEqual([1, 0]);
  expect(it.fetch).toHaveBeenCalledExactlyOnceWith(site.href, { method: "HEAD", cache: "no-store" });
  expect(it.reload).toHaveBeenCalledOnce();
});

it("without the site's server nothing is forgotten", async () => {
  for (const answer of [() => Promise.reject(new TypeError("no network")), async () => new Response(null, { status: 404 })]) {
    const it = browser(answer);
    expect(await loadAnew(site, it)).toBe(false);
    expect([it.kept.size, it.reload.mock.calls.length]).toEqual([4, 0]);
  }
});

it("a browser that keeps nothing reloads", async () => {
  const it = { ...browser(async () => new Response()), caches: undefined, workers: undefined };
  expect(await loadAnew(site, it)).toBe(true);
  expect(it.reload).toHaveBeenCalledOnce();
});
