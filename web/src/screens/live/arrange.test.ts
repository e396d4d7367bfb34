import { describe, expect, it } from "vitest";
import { keysOf, moved, placeAt } from "./arrange";

describe("keysOf", () => {
  const of = (...names: string[]) => keysOf(names.map((name) => ({ names: [name] })));

  it("gives equal tiles different keys, and a moved one the same", () => {
    expect(new Set(of("FREQ", "TWAT", "FREQ")).size).toBe(3);
    expect(of("FREQ", "TWAT")).toEqual(of("TWAT", "FREQ").reverse());
  });
});

describe("moved", () => {
  it("moves forward and back", () => {
    expect(moved(["a", "b", "c", "d"], 0, 2)).toEqual(["b", "c", "a", "d"]);
    expect(moved(["a", "b", "c", "d"], 3, 1)).toEqual(["a", "d", "b", "c"]);
    expect(moved(["a", "b"], 1, 1)).toEqual(["a", "b"]);
  });

  it("ignores an index that does not exist", () => {
    expect(moved(["a", "b"], 5, 0)).toEqual(["a", "b"]);
  });
});

describe("placeAt", () => {
  const boxes = [
    { left: 0, right: 10, top: 0, bottom: 10 },
    { left: 20, right: 30, top: 0, bottom: 10 },
  ];

  it("returns the box under the point, else the nearest", () => {
    expect(placeAt(boxes, 25, 5)).toBe(1);
    expect(placeAt(boxes, 12, 40)).toBe(0);
    expect(placeAt([], 0, 0)).toBeNull();
  });
});
