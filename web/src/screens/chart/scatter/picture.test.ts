import { describe, expect, it } from "vitest";
import { moved, roomy, shortened, zoomed } from "./picture";

describe("the axes", () => {
  it("have room around the values, and a least width", () => {
    expect(roomy(0, 100, 1)).toEqual([-4, 104]);
    expect(roomy(5, 5, 2)).toEqual([4, 6]);
    expect(roomy(Infinity, -Infinity, 2)).toEqual([0, 1]);
    const [low, high] = roomy(7, 7, 0);
    expect(high).toBeGreaterThan(low);
  });

  it("are zoomed around a place, and moved", () => {
    expect(zoomed([0, 10], 0.5, 0)).toEqual([0, 5]);
    expect(zoomed([0, 10], 0.5, 1)).toEqual([5, 10]);
    expect(moved([0, 10], 0.1)).toEqual([-1, 9]);
  });
});

describe("the remark", () => {
  const widthOf = (text: string) => 10 * text.length;

  it("is never squeezed: what has no room is left out", () => {
    expect(shortened("Grey: cold.pcapng", 170, widthOf)).toBe("Grey: cold.pcapng");
    expect(shortened("Grey: cold.pcapng", 70, widthOf)).toBe("Grey:…");
    expect(shortened("Grey: cold.pcapng", 5, widthOf)).toBe("");
  });
});
