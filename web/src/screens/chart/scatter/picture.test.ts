import { describe, expect, it } from "vitest";
import { moved, shortened, zoomed } from "./picture";

describe("the axes", () => {
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
