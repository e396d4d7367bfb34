import { describe, expect, it } from "vitest";
import { compare } from "./compare";

describe("comparing", () => {
  const side = (first: number, ...data: number[]) => ({ first, data: Uint8Array.from(data) });
  it("counts differing bytes and bytes of one side only", () => {
    const found = compare(side(0, 1, 2, 3), side(1, 2, 4, 5));
    expect(found).toMatchObject({ equal: 1, different: 1, onlyA: 1, onlyB: 1, left: 0 });
  });
  it("finds no difference in equal data", () => {
    const data = Array.from({ length: 100 }, (_, at) => at);
    const found = compare(side(0x20, ...data), side(0x20, ...data));
    expect(found).toMatchObject({ equal: 100, different: 0, onlyA: 0, onlyB: 0 });
    expect(found.lines).toEqual([{ kind: "equal", address: 0x20, bytes: 100 }]);
  });
  it("shows a row of context and merges equal rows", () => {
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
    expect(found.lines.filter((line) => line.kind === "equal").map((line) => line.bytes)).toEqual([64, 48]);
  });
  it("counts beyond the rows shown", () => {
    const a = side(0, ...Array.from({ length: 1600 }, () => 0));
    const b = side(0, ...Array.from({ length: 1600 }, () => 1));
    const found = compare(a, b, 10);
    expect(found.different).toBe(1600);
    expect(found.lines).toHaveLength(10);
    expect(found.left).toBe(90);
  });
});
