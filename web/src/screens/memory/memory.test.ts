import { describe, expect, it } from "vitest";
import { mapOf, passOf, percent, secondsFor } from "./dumps/blocks";
import { bytesOf, readsFor, restored, valueOf, type Cell } from "./cells/cells";
import { compare } from "./dumps/compare";
import { GLOW_MS, Glow } from "./cells/glow";

const cell = (address: number, formula = "b", space: Cell["space"] = "ram"): Cell => ({
  id: `${space}${address}`,
  space,
  address,
  name: "",
  formula,
  unit: "",
});

describe("glow", () => {
  it("starts with a change, not with the first sight, and ends after two seconds", () => {
    const glow = new Glow();
    expect(glow.take(Uint8Array.of(1, 2), 0x10, 0)).toBe(0);
    expect(glow.next(0)).toBeNull();
    expect(glow.take(Uint8Array.of(1, 3), 0x10, 100)).toBe(1);
    expect([...glow.at(100)]).toEqual([0x11]);
    expect(glow.next(600)).toBe(GLOW_MS - 500);
    expect([...glow.at(100 + GLOW_MS)]).toEqual([]);
  });
  it("glows on if it changes again", () => {
    const glow = new Glow();
    for (const [value, now] of [
      [1, 0],
      [2, 10],
      [3, 1500],
    ] as const)
      glow.take(Uint8Array.of(value), 0, now);
    expect(glow.at(2500).has(0)).toBe(true);
  });
  it("knows nothing of another space", () => {
    const glow = new Glow();
    glow.take(Uint8Array.of(1), 0, 0);
    glow.reset();
    expect(glow.take(Uint8Array.of(2), 0, 1)).toBe(0);
  });
});

describe("watched cells", () => {
  it("that are near are read together, others not", () => {
    const reads = readsFor([cell(0x50), cell(0x10, "w"), cell(0x14), cell(0x10, "b", "xram")]);
    expect(reads.map(({ space, address, count }) => [space, address, count])).toEqual([
      ["ram", 0x10, 5],
      ["ram", 0x50, 1],
      ["xram", 0x10, 1],
    ]);
  });
  it("of SFR are read one by one", () => {
    expect(readsFor([cell(0x80, "b", "sfr"), cell(0x81, "b", "sfr")])).toHaveLength(2);
  });
  it("get their own bytes and their value", () => {
    const two = cell(0x12, "w / 10");
    const [read] = readsFor([cell(0x10), two]);
    const data = Uint8Array.of(9, 0, 0x64, 0x00);
    expect(bytesOf(two, read!, data)).toEqual(Uint8Array.of(0x64, 0));
    expect(valueOf(two, bytesOf(two, read!, data))).toBe(10);
  });
  it("never reach over the end of the space", () => {
    expect(readsFor([cell(0xff, "w")])[0]!.count).toBe(1);
    expect(valueOf(cell(0xff, "w"), Uint8Array.of(1))).toBeNull();
  });
  it("with a wrong formula have no value", () => {
    expect(valueOf(cell(0, "b +"), Uint8Array.of(1))).toBeNull();
  });
  it("survive a damaged store", () => {
    expect(restored(null)).toEqual([]);
    expect(restored("{")).toEqual([]);
    expect(restored("{}")).toEqual([]);
    const bad = [
      null,
      1,
      { ...cell(1), space: "eeprom" },
      { ...cell(1), address: 0x100 },
      { ...cell(1), name: 1 },
    ];
    expect(restored(JSON.stringify([...bad, cell(2)]))).toEqual([cell(2)]);
  });
});

describe("comparing", () => {
  const side = (first: number, ...data: number[]) => ({ first, data: Uint8Array.from(data) });
  it("finds what differs and what only one side has", () => {
    const found = compare(side(0, 1, 2, 3), side(1, 2, 4, 5));
    expect(found).toMatchObject({ equal: 1, different: 1, onlyA: 1, onlyB: 1, left: 0 });
  });
  it("finds nothing in the same", () => {
    const data = Array.from({ length: 100 }, (_, at) => at);
    const found = compare(side(0x20, ...data), side(0x20, ...data));
    expect(found).toMatchObject({ equal: 100, different: 0, onlyA: 0, onlyB: 0 });
    expect(found.lines).toEqual([{ kind: "equal", address: 0x20, bytes: 100 }]);
  });
  it("shows a row of context and folds the rest", () => {
    const a = Array.from({ length: 160 }, () => 0);
    const b = [...a];
    b[80] = 1;
    const found = compare(side(0, ...a), side(0, ...b));
    expect(found.lines.map((line) => [line.kind, line.address])).toEqual([
      ["equal", 0x00],
      ["row", 0x40],
      ["row", 0x50],
      ["row", 0x60],
      ["equal", 0x70],
    ]);
    expect(found.lines.filter((line) => line.kind === "equal").map((line) => line.bytes)).toEqual([
      64, 48,
    ]);
  });
  it("counts on beyond what it shows", () => {
    const a = side(0, ...Array.from({ length: 1600 }, () => 0));
    const b = side(0, ...Array.from({ length: 1600 }, () => 1));
    const found = compare(a, b, 10);
    expect(found.different).toBe(1600);
    expect(found.lines).toHaveLength(10);
    expect(found.left).toBe(90);
  });
});

describe("the map of blocks", () => {
  it("counts and lays out", () => {
    const blocks = Array.from({ length: 70 }, (_, at) => ({
      first: at * 16,
      count: 16,
      state: at < 2 ? ("done" as const) : at === 2 ? ("retried" as const) : ("todo" as const),
    }));
    const map = mapOf(blocks);
    expect([map.columns, map.rows]).toEqual([32, 3]);
    expect(map.counts).toEqual({ done: 2, retried: 1, failed: 0, todo: 67 });
    expect(map.cells[33]).toMatchObject({ column: 1, row: 1 });
    expect(mapOf([])).toMatchObject({ rows: 1, cells: [] });
  });
  it("is complete only when it is", () => {
    expect(percent(65535, 65536)).toBe(99);
    expect(percent(65536, 65536)).toBe(100);
    expect(percent(0, 0)).toBe(0);
  });
  it("takes what the wire takes: 72 s for 64 KiB (§5)", () => {
    expect(secondsFor("code", 65536, 255)).toBeGreaterThan(70);
    expect(secondsFor("code", 65536, 255)).toBeLessThan(74);
  });
});

it("a dump that is read twice has two passes over the same bytes", () => {
  const dump = { first: 0x100, last: 0x1ff, total: 512 };
  expect(passOf({ ...dump, done: 100 })).toEqual({ done: 100, size: 256, pass: 1, passes: 2 });
  expect(passOf({ ...dump, done: 300 })).toEqual({ done: 44, size: 256, pass: 2, passes: 2 });
  expect(passOf({ ...dump, done: 512 })).toEqual({ done: 256, size: 256, pass: 2, passes: 2 });
  expect(passOf({ ...dump, total: 256, done: 256 })).toEqual({ done: 256, size: 256, pass: 1, passes: 1 });
});
