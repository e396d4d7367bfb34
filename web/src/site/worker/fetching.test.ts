import { beforeEach, expect, test, vi } from "vitest";
import { counting } from "./fetching";

const AT = "https://here/program-0/";

function answer(name: string, body: BodyInit | null, status = 200): Response {
  return Object.defineProperty(new Response(body, { status }), "url", { value: AT + name });
}

async function gzip(text: string): Promise<ArrayBuffer> {
  return new Response(new Blob([text]).stream().pipeThrough(new CompressionStream("gzip"))).arrayBuffer();
}

beforeEach(() => {
  vi.stubGlobal("self", globalThis);
});

test("a .pack comes unpacked, and counts by what has travelled", async () => {
  const body = await gzip("a".repeat(100_000));
  vi.stubGlobal("fetch", () => Promise.resolve(answer("a.pack", body)));
  const counts: [number, number][] = [];
  const size = { bytes: body.byteLength, compressed: body.byteLength };
  const stop = counting(new Map([[`${AT}a.pack`, size]]), (...count) => counts.push(count));
  expect(await (await fetch(`${AT}a.pack`)).text()).toHaveLength(100_000);
  await vi.waitFor(() => {
    expect(counts.at(-1)).toEqual([body.byteLength, body.byteLength]);
  });
  stop();
});

test("other files, and a server's answer that a .pack is missing, come as they are", async () => {
  vi.stubGlobal("fetch", (name: string) => Promise.resolve(answer(name, name, name.endsWith(".pack") ? 404 : 200)));
  const stop = counting(new Map(), () => {});
  expect(await (await fetch("a.wasm")).text()).toBe("a.wasm");
  const missing = await fetch("a.pack");
  expect([missing.status, await missing.text()]).toEqual([404, "a.pack"]);
  stop();
});

test("fetch is the browser's own afterwards", async () => {
  const body = await gzip("a");
  vi.stubGlobal("fetch", () => Promise.resolve(answer("a.pack", body)));
  counting(new Map(), () => {})();
  expect((await (await fetch("a.pack")).arrayBuffer()).byteLength).toBe(body.byteLength);
});
