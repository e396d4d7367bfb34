// The pool is opened on what a crash leaves after every single step, and in the middle of a write.

import { expect, test } from "vitest";
import { FakeDisk } from "../../../test/fakeDisk";
import { Pool } from "./pool";
import { bytes, content, find } from "../../../test/poolRig";
import { randoms } from "../../../test/random";

type Files = Record<string, string>;

/** Where the pool was between two calls: the files, and how many steps the disk had done. */
interface Moment {
  files: Files;
  steps: number;
}

/** Do `count` random calls; return all moments between them. */
async function history(disk: FakeDisk, random: () => number, count: number): Promise<Moment[]> {
  const pool = await Pool.open(disk, () => moments.length * 700);
  const moments: Moment[] = [{ files: {}, steps: disk.steps.length }];
  const any = <T>(items: T[]): T | undefined => items[Math.floor(random() * items.length)];
  const names = ["a", "b", "c/d", "c/e"];
  for (let n = 0; n < count; n++) {
    const files = [...pool.all()];
    const file = any(files);
    const name = any(names)!;
    const other = files.find((it) => it.path === name) ?? null;
    const kind = random();
    if (kind < 0.25 || !file) {
      if (!other) pool.create(name);
    } else if (kind < 0.55) pool.write(file, bytes(`<${n}>`.repeat(3)), file.size);
    else if (kind < 0.65) pool.write(file, bytes("!!"), Math.floor(random() * file.size));
    else if (kind < 0.75) pool.truncate(file, Math.floor(random() * 20));
    else if (kind < 0.8) pool.flush(file);
    else if (kind < 0.93) {
      if (other !== file) pool.rename(file, name, other);
    } else pool.remove(file);
    moments.push({ files: content(pool), steps: disk.steps.length });
  }
  return moments;
}

/** Whether `files` are those of before or after, or a write got as far as it got. */
function fits(files: Files, before: Files, after: Files): boolean {
  const same = (one: Files, other: Files) =>
    Object.keys(one).length === Object.keys(other).length && Object.keys(one).every((it) => one[it] === other[it]);
  if (same(files, before) || same(files, after)) return true;
  const changed = Object.keys(after).filter((name) => before[name] !== after[name]);
  const [name] = changed;
  const renamed = Object.keys(before).some((it) => after[it] === undefined);
  if (renamed || changed.length !== 1 || name === undefined || before[name] === undefined) return false;
  const [old, now, found] = [before[name], after[name]!, files[name]];
  if (found === undefined || !same({ ...files, [name]: now }, after)) return false;
  // Some of the new bytes, then what was there before.
  return Array.from({ length: now.length + 1 }, (_, at) => now.slice(0, at) + old.slice(at)).includes(found);
}

test("after any step, and in the middle of any, the files are those of before or after the call", async () => {
  let cuts = 0;
  for (let seed = 1; seed <= 4; seed++) {
    const disk = new FakeDisk();
    const moments = await history(disk, randoms(seed), 50);
    for (const [index, after] of moments.entries()) {
      const before = moments[index - 1];
      if (!before) continue;
      for (let steps = before.steps; steps <= after.steps; steps++) {
        for (const torn of steps < after.steps ? [0, 0.002, 0.01, 0.5] : [0]) {
          const found = content(await Pool.open(disk.after(steps, torn)));
          cuts++;
          if (!fits(found, before.files, after.files)) {
            expect.fail(`seed ${seed}, call ${index}, step ${steps}, ${torn}: ${JSON.stringify({ before, found, after })}`);
          }
        }
      }
    }
  }
  expect(cuts).toBeGreaterThan(700);
});

test("a start that is interrupted itself changes nothing", async () => {
  const disk = new FakeDisk();
  const moments = await history(disk, randoms(9), 60);
  for (const { files, steps } of moments.slice(-20)) {
    for (const torn of [0, 0.5]) {
      const crashed = disk.after(steps);
      crashed.steps.push(...disk.steps.slice(0, steps));
      const begun = crashed.steps.length;
      await Pool.open(crashed);
      for (let at = begun; at <= crashed.steps.length; at++) {
        expect(content(await Pool.open(crashed.after(at, torn)))).toEqual(files);
      }
    }
  }
});

test("a power failure leaves the old file or the new one, each whole", async () => {
  const disk = new FakeDisk();
  const pool = await Pool.open(disk);
  const done: number[] = [];
  const deleted: { from: number; to: number }[] = [];
  const text = (version: number) => `version ${version} `.repeat((version % 5) + 1);
  for (let version = 0; version < 30; version++) {
    // As mikas.saving.save, beside a file that is recorded and one that is deleted.
    const made = pool.create("x.new");
    pool.write(made, bytes(text(version)), 0);
    pool.flush(made);
    const former = [...pool.all()].find((file) => file.path === "x");
    pool.rename(made, "x", former ?? null);
    done.push(disk.steps.length);
    const recorded = version ? find(pool, "r") : pool.create("r");
    pool.write(recorded, bytes("."), version); // never flushed, but found: no data without their name
    const brief = pool.create("brief");
    pool.write(brief, bytes("brief"), 0);
    pool.flush(brief);
    const flushed = disk.steps.length;
    pool.remove(brief);
    deleted.push({ from: flushed, to: disk.steps.length });
  }
  const random = randoms(4);
  for (let n = 0; n < 200; n++) {
    const steps = done[0]! + Math.floor(random() * (disk.steps.length - done[0]!));
    const version = done.findLastIndex((it) => it <= steps);
    const opened = await Pool.open(disk.afterPowerFailure(steps, random));
    const { x, r, brief } = content(opened);
    if (x !== text(version) && x !== text(version + 1)) {
      expect.fail(`step ${steps}: version ${version}, found ${x}`);
    }
    if (deleted.some(({ from, to }) => from <= steps && steps <= to)) {
      expect(["brief", undefined], `step ${steps}`).toContain(brief);
    }
    if (steps >= done[1]!) expect(r, `step ${steps}`).toBeDefined();
    expect(opened.damaged).toEqual([]);
  }
});
