import { describe, expect, it } from "vitest";
import { displayValueOf } from "./displayValue";

const held = { value: 840, time: 100 };
const kind = (age: number, period: number) => displayValueOf(held, 100 + age, period).kind;

describe("displayValueOf", () => {
  it("depends on the channel's period", () => {
    expect(kind(0.4, 0.03)).toBe("fresh");
    expect(kind(0.6, 0.03)).toBe("stale");
    expect(kind(3, 1)).toBe("fresh");
    expect(kind(5, 1)).toBe("stale");
  });

  it("has no value after a long time", () => {
    expect(kind(3.5, 0.03)).toBe("none");
    expect(kind(11, 1)).toBe("stale");
    expect(kind(13, 1)).toBe("none");
    expect(displayValueOf(undefined, 100, 1).kind).toBe("none");
  });

  it("returns the age of a stale value", () => {
    expect(displayValueOf(held, 102, 0.1)).toEqual({ kind: "stale", value: 840, age: 2 });
  });
});
