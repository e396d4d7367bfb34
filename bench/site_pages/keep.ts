// Puts a file among those that the site keeps, and measures how long small appends take there.
import { opfsFolder } from "../../web/src/site/storage/folder";
import { Pool } from "../../web/src/site/storage/pool";

const APPENDS = 20_000;

self.onmessage = async ({ data: { url, path } }: MessageEvent<{ url: string; path: string }>) => {
  const pool = await Pool.open(await opfsFolder());
  const file = pool.create(path);
  pool.write(file, new Uint8Array(await (await fetch(url)).arrayBuffer()), 0);
  pool.flush(file);
  const small = pool.create("appended");
  const bytes = new Uint8Array(60);
  const began = performance.now();
  for (let at = 0; at < APPENDS; at += 1) pool.write(small, bytes, at * bytes.length);
  const each = ((performance.now() - began) / APPENDS) * 1000;
  pool.remove(small);
  pool.close();
  self.postMessage(each);
};
