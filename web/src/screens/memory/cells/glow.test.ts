import { describe, expect, it } from "vitest";
import { GLOW_MS, Glow } from "./glow";

describe("glow", () => {
  it("starts with a change, not with the first read, and ends after two seconds", () => {
    const glow = new Glow();
    expect(glow.take(Uint8Array.of(1, 2), 0x10, 0)).toBe(0);
    expect(glow.next(0)).toBeNull();
    expect(glow.take(Uint8Array.of(1, 3), 0x10, 100)).toBe(1);
    expect([...glow.at(100)]).toEqual([0x11]);
    expect(glow.next(600)).toBe(GLOW_MS - 500);
    expect([...glow.at(100 + GLOW_MS)]).toEqual([]);
  });
  it("restarts when the byte changes again", () => {
    const glow = new Glow();
    for (const [value, now] of [
      [1, 0],
      [2, 10],
      [3, 1500],
    ] as const)
      glow.take(Uint8Array.of(value), 0, now);
    expect(glow.at(2500).has(0)).toBe(true);
  });
  it("forgets after a reset", () => {
    const glow = new Glow();
    glow.take(Uint8Array.of(1), 0, 0);
    glow.reset();
    expect(glow.take(Uint8Array.of(2), 0, 1)).toBe(0);
  });
});
