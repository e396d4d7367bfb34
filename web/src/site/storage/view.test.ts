import { expect, test } from "vitest";
import { FakeDisk } from "../../../test/fakeDisk";
import type { Holding } from "./folder";
import { Pool } from "./pool";
import { bytes, content, find, textOf } from "../../../test/poolRig";
import { randoms } from "../../../test/random";
import { PoolView } from "./view";

/** How a browser opens the files of the pool. */
const HOLDINGS = ["shared", "alone"] as const;
const diskOf = (holding: Holding): FakeDisk => Object.assign(new FakeDisk(), { shares: holding === "shared" });

test.each(HOLDINGS)("a view sees what the pool does, whose files are open %s", async (holding) => {
  const disk = diskOf(holding);
  const pool = await Pool.open(disk);
  const view = await PoolView.open(disk);
  const random = randoms(3);
  const names = ["a", "b", "c"];
  for (let n = 0; n < 300; n++) {
    const name = names[Math.floor(random() * 3)]!;
    const files = [...pool.all()];
    const other = files.find((file) => file.path === name);
    if (!other) pool.create(name);
    else if (random() < 0.2) pool.remove(other);
    else if (random() < 0.5) pool.write(other, bytes(`${n}`), other.size);
    else if (files[0] !== other) pool.rename(files[0]!, name, other);
    await pool.grown();
    await view.refresh();
    expect(content(view)).toEqual(content(pool));
  }
});

test.each(HOLDINGS)("a file that grows is seen to grow, and stays the same one (%s)", async (holding) => {
  const disk = diskOf(holding);
  let now = 0;
  const pool = await Pool.open(disk, () => now);
  const file = pool.create("x");
  const view = await PoolView.open(disk);
  const seen = find(view, "x");
  expect(seen.id).toBe(file.id);
  now = 5000;
  pool.write(file, bytes("more"), 0);
  await view.refresh();
  expect(textOf(seen)).toBe("more");
  expect(find(view, "x")).toBe(seen);
  expect(seen.mtime).toBe(5000);
});

test("refreshes at the same time open each slot once", async () => {
  const disk = new FakeDisk();
  const pool = await Pool.open(disk);
  const view = await PoolView.open(disk);
  for (let n = 0; n < 20; n++) pool.create(`${n}`);
  await pool.grown();
  await Promise.all([view.refresh(), view.refresh(), view.refresh()]);
  expect(content(view)).toEqual(content(pool));
  view.close();
  pool.close();
  disk.shares = false; // so a handle that is still open would be in the way
  await Pool.open(disk);
});

test.each(HOLDINGS)("the bytes of another file are never those of a deleted one (%s)", async (holding) => {
  const disk = diskOf(holding);
  const pool = await Pool.open(disk);
  const file = pool.create("x");
  pool.write(file, bytes("x"), 0);
  const view = await PoolView.open(disk);
  const seen = find(view, "x");
  pool.remove(file);
  expect(() => textOf(seen)).toThrow("errno 72");
  for (let n = 0; n < 32; n++) pool.write(pool.create(`${n}`), bytes("y"), 0);
  expect(() => seen.read(new Uint8Array(1), 0)).toThrow("errno 72");
});

test("a view writes nothing, and does not keep the pool from being opened", async () => {
  const disk = new FakeDisk();
  const pool = await Pool.open(disk);
  pool.create("x");
  pool.close();
  const steps = disk.steps.length;
  const view = await PoolView.open(disk);
  await view.refresh();
  expect(disk.steps.length).toBe(steps);
  await Pool.open(disk);
  view.close();
});
