import { expect, test } from "vitest";
import { StorageError } from "./errors";
import { FakeDisk } from "../../../test/fakeDisk";
import { COPY, DATA, VERSION } from "./header";
import { Pool } from "./pool";
import { bytes, content, error, find } from "../../../test/poolRig";

test("files survive closing, with their numbers and times", async () => {
  const disk = new FakeDisk();
  let now = 1000;
  const pool = await Pool.open(disk, () => now);
  const first = pool.create("a/x");
  const second = pool.create("y");
  pool.write(second, bytes("first "), 0);
  now = 1300.5;
  pool.write(second, bytes("second"), 6);
  pool.close();
  const again = await Pool.open(disk);
  expect(content(again)).toEqual({ "a/x": "", y: "first second" });
  expect(find(again, "y")).toMatchObject({ id: second.id, mtime: 1300.5 });
  expect(find(again, "a/x").id).toBe(first.id);
  expect(again.create("z").id).toBeGreaterThan(Math.max(first.id, second.id));
  expect([...again.all()].reduce((sum, { size }) => sum + size, 0)).toBe(12);
});

test("the header is written once a second while a file grows, and for a flush", async () => {
  const disk = new FakeDisk();
  let now = 0;
  const pool = await Pool.open(disk, () => now);
  const file = pool.create("x");
  pool.hold(file);
  const headers = () => disk.steps.filter((it) => it.kind === "write" && it.at < DATA).length;
  const before = headers();
  for (; now < 10_000; now += 20) pool.write(file, bytes("60 bytes"), file.size);
  expect(headers() - before).toBe(9);
  pool.flush(file);
  pool.flush(file);
  expect(headers() - before).toBe(10);
  now += 20;
  pool.write(file, bytes("the end"), file.size);
  pool.letGo(file);
  expect(headers() - before).toBe(11);
  expect(find(await Pool.open(disk.after(disk.steps.length)), "x").mtime).toBe(now);
});

test("a pool that is open elsewhere is not opened", async () => {
  const disk = new FakeDisk();
  const pool = await Pool.open(disk);
  expect(await error(Pool.open(disk))).toMatchObject({ reason: "held" });
  pool.close();
  await Pool.open(disk);
});

test("a pool of a later format is left as it is", async () => {
  const disk = new FakeDisk();
  const pool = await Pool.open(disk);
  pool.create("x");
  pool.close();
  for (const copy of [0, COPY]) {
    const newer = disk.after(disk.steps.length);
    newer.files.get("000")![copy + 8] = VERSION + 1;
    newer.files.get("000")!.set(newer.files.get("000")!.subarray(0, 8), copy || 0);
    newer.files.get("001")!.fill(0, 0, DATA); // one that would be prepared
    newer.files.get("000")!.set(bytes("mikaskpt"), copy);
    const refusal = await error(Pool.open(newer));
    expect(refusal).toBeInstanceOf(StorageError);
    expect(refusal).toMatchObject({ reason: "newer" });
    expect(newer.steps).toEqual([]);
    expect(await error(Pool.open(newer))).toMatchObject({ reason: "newer" }); // not "held"
  }
});

test("a recording that has lost its header is listed under another name", async () => {
  const disk = new FakeDisk();
  const pool = await Pool.open(disk);
  for (const path of ["recordings/a.pcapng", "recordings/recovered 000.pcapng"]) pool.write(pool.create(path), bytes(`\n\r\r\n${path}`), 0);
  pool.close();
  disk.files.get("000")!.fill(0xff, 0, DATA);
  for (let start = 0; start < 2; start++) {
    const again = await Pool.open(disk);
    expect(again.damaged).toEqual([]);
    expect(content(again)).toEqual({
      "recordings/recovered 000.pcapng": "\n\r\r\nrecordings/recovered 000.pcapng",
      "recordings/recovered 000 (2).pcapng": "\n\r\r\nrecordings/a.pcapng",
    });
    again.close();
  }
});

test("other data without a header are kept aside", async () => {
  const disk = new FakeDisk();
  const pool = await Pool.open(disk);
  pool.write(pool.create("x"), bytes("precious"), 0);
  pool.create("y");
  pool.close();
  disk.files.get("000")!.fill(0xff, 0, DATA);
  for (let start = 0; start < 2; start++) {
    const again = await Pool.open(disk);
    expect(again.damaged).toEqual(["000"]);
    expect(Object.keys(content(again))).toContain("y");
    for (let n = 0; n < 10; n++) again.create(`${start} ${n}`);
    again.close();
  }
  expect(disk.files.get("000")!.subarray(DATA)).toEqual(bytes("precious"));
});

test("the pool grows before it runs dry", async () => {
  const disk = new FakeDisk();
  const pool = await Pool.open(disk);
  for (let n = 0; n < 500; n++) {
    pool.create(`${n}`);
    if (n % 16 === 0) await pool.grown();
  }
  pool.close();
  const again = await Pool.open(disk);
  expect([...again.all()].length).toBe(500);
});

test("slots of deleted files are used again, after all others", async () => {
  const disk = new FakeDisk();
  const pool = await Pool.open(disk);
  const slots = new Set<string>();
  for (let n = 0; n < 200; n++) {
    const file = pool.create("x");
    expect(file.size).toBe(0);
    pool.write(file, bytes("data"), 0);
    slots.add(file.slot.name);
    pool.remove(file);
  }
  expect(slots.size).toBe(32);
  expect(disk.used).toBe(32 * DATA);
});

test.each(["short", "throws", "number"] as const)("on a full disk (%s) the pool opens, renames and deletes", async (full) => {
  const disk = new FakeDisk();
  disk.full = full;
  let pool = await Pool.open(disk);
  for (const name of ["a", "b", "c"]) pool.write(pool.create(name), bytes(name), 0);
  for (let n = 0; n < 29; n++) pool.create(`${n}`);
  pool.close();
  disk.room = 0;
  pool = await Pool.open(disk);
  expect(() => pool.create("one more")).toThrow();
  pool.rename(find(pool, "a"), "b", find(pool, "b"));
  pool.remove(find(pool, "c"));
  disk.room = disk.used;
  const made = pool.create("d");
  expect(() => pool.write(made, bytes("d"), 0)).toThrow();
  expect(content(pool)).toMatchObject({ b: "a", d: "" });
  pool.close();
  expect(content(await Pool.open(disk))).toMatchObject({ b: "a", d: "" });
});

test("a disk that fails during a rename leaves both files", async () => {
  const disk = new FakeDisk();
  const pool = await Pool.open(disk);
  pool.write(pool.create("a"), bytes("new"), 0);
  pool.write(pool.create("b"), bytes("old"), 0);
  disk.failure = new DOMException("gone", "InvalidStateError");
  expect(() => pool.rename(find(pool, "a"), "b", find(pool, "b"))).toThrow("errno 29");
  expect(() => pool.remove(find(pool, "b"))).toThrow("errno 29");
  disk.failure = null;
  expect(content(pool)).toEqual({ a: "new", b: "old" });
  pool.close();
  expect(content(await Pool.open(disk))).toEqual({ a: "new", b: "old" });
});
