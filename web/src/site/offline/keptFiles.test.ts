import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { beforeEach, expect, it } from "vitest";
import { KeptFiles, POLICY } from "./keptFiles";

const SITE = "https://host.example/tools/mikas/";

class FakeCache {
  readonly kept = new Map<string, Response>();

  async match(address: string): Promise<Response | undefined> {
    return this.kept.get(address)?.clone();
  }

  async put(address: string, response: Response): Promise<void> {
    this.kept.set(address, response);
  }
}

class FakeCaches {
  readonly all = new Map<string, FakeCache>();
  broken = false;

  async open(name: string): Promise<FakeCache> {
    if (!this.all.has(name)) this.all.set(name, new FakeCache());
    return this.all.get(name)!;
  }

  async match(address: string, { cacheName }: { cacheName: string }): Promise<Response | undefined> {
    if (this.broken) throw new DOMException("the disk is damaged", "UnknownError");
    return this.all.get(cacheName)?.match(address);
  }

  async keys(): Promise<string[]> {
    return [...this.all.keys()];
  }

  async delete(name: string): Promise<boolean> {
    return this.all.delete(name);
  }
}

let host: Record<string, string>;
let stale: Record<string, string>;
let asked: string[];
let caches: FakeCaches;

/** The host, behind a cache of the browser that has `stale` files. */
async function fetch(address: string, { integrity, cache }: RequestInit = {}): Promise<Response> {
  const path = address.slice(SITE.length);
  asked.push(path);
  const content = cache === "reload" ? host[path] : (stale[path] ?? host[path]);
  if (content === undefined) return new Response("", { status: 404 });
  if (integrity && integrity !== `sha256-${createHash("sha256").update(content).digest("base64")}`) throw new TypeError("integrity");
  return new Response(content, { headers: { "Content-Type": path.endsWith(".html") ? "text/html" : "text/javascript" } });
}

function publish(version: string, files: Record<string, string>): void {
  const listed = Object.entries(files).map(([path, content]) => ({ path, sha256: createHash("sha256").update(content).digest("hex") }));
  host = { ...files, "files.json": JSON.stringify({ version, files: listed }) };
}

const site = (version: string) =>
  new KeptFiles(version, new URL(SITE), caches as unknown as CacheStorage, fetch as typeof globalThis.fetch);

beforeEach(() => {
  asked = [];
  stale = {};
  caches = new FakeCaches();
  publish("1", { "index.html": "<one>", "assets/a-1.js": "a", "program-1/mikas.pack": "python" });
});

it("the page starts from what is kept, with the policy that a static host does not send", async () => {
  await site("1").keep();
  host = {};
  const found = async (address: string) => (await site("1").find(address))!;
  for (const address of [SITE, `${SITE}?from=home`, `${SITE}index.html`]) expect(await (await found(address)).text()).toBe("<one>");
  const page = await found(SITE);
  expect([page.headers.get("Content-Type"), page.headers.get("Content-Security-Policy")]).toEqual([
    "text/html",
    `${POLICY}; frame-ancestors 'none'`,
  ]);
  expect(await site("1").find(`${SITE}assets/b-1.js`)).toBe(undefined);
});

it("other files are the browser's own answers, whose bytes do not pass through the service worker", async () => {
  await site("1").keep();
  const address = `${SITE}assets/a-1.js`;
  const kept = new Response("a", { headers: { "Content-Type": "text/javascript" } });
  caches.match = () => Promise.resolve(kept);
  expect(await site("1").find(address)).toBe(kept);
});

it("where nothing can be read the network is left", async () => {
  await site("1").keep();
  expect(await site("2").find(SITE)).toBe(undefined);
  expect(await caches.keys()).toEqual(["mikas /tools/mikas/ 1"]);
  caches.broken = true;
  expect(await site("1").find(SITE)).toBe(undefined);
});

it("the policy is the page's own", () => {
  expect(readFileSync(new URL("../../../site.html", import.meta.url), "utf8")).toContain(`content="${POLICY}"`);
});

it("a new version loads what has changed, and leaves the one in use alone until it takes over", async () => {
  await site("1").keep();
  publish("2", { "index.html": "<two>", "assets/a-2.js": "b", "program-1/mikas.pack": "python" });
  asked = [];
  await site("2").keep();
  expect(asked.sort()).toEqual(["assets/a-2.js", "files.json", "index.html"]);
  expect(await (await site("1").find(SITE))!.text()).toBe("<one>");
  expect(await (await site("2").find(`${SITE}program-1/mikas.pack`))!.text()).toBe("python");
  await site("2").forgetOthers();
  expect(await caches.keys()).toEqual(["mikas /tools/mikas/ 2"]);
});

it("other sites of the same origin keep their caches", async () => {
  await caches.open("mikas /other/ 7");
  await site("1").keep();
  await site("1").forgetOthers();
  expect((await caches.keys()).sort()).toEqual(["mikas /other/ 7", "mikas /tools/mikas/ 1"]);
});

it("a stale file of another cache is loaded again, a damaged one is not kept", async () => {
  stale = { "index.html": "<zero>" };
  await site("1").keep();
  expect(await (await site("1").find(SITE))!.text()).toBe("<one>");
  caches = new FakeCaches();
  host["index.html"] = "<captive portal>";
  await expect(site("1").keep()).rejects.toThrow("integrity");
});

it("nothing is kept of a host that is amid a change", async () => {
  publish("2", { "index.html": "<two>" });
  await expect(site("1").keep()).rejects.toThrow("version 2");
  publish("1", { "index.html": "<one>", "assets/a-1.js": "a" });
  delete host["assets/a-1.js"];
  await expect(site("1").keep()).rejects.toThrow("404");
});
