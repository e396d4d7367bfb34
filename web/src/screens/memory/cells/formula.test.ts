import { describe, expect, it } from "vitest";
import { FormulaProblem, compile } from "./formula";

const of = (text: string, ...bytes: number[]) => compile(text).value(Uint8Array.from(bytes));

describe("the formulas of §4", () => {
  it.each([
    ["b - 40", [125], 85],
    ["b·40", [21], 840],
    ["s / 2", [0xf6], -5],
    ["b / 10", [142], 14.2],
    ["w / 125", [0x58, 0x02], 4.8],
    ["0,5 + b/256", [128], 1],
    ["(b - 128)/256 - 0.5", [128], -0.5],
    ["b & 0x40", [0x5f], 0x40],
    ["i", [0xff, 0xff], -1],
    ["b2", [1, 2], 2],
    ["−b + 1", [1], 0],
    ["2 + 3 * b", [4], 14],
    ["10 - 2 - 3", [0], 5],
    ["100 / 10 / 2", [0], 5],
  ])("%s", (text, bytes, value) => {
    expect(of(text, ...bytes)).toBeCloseTo(value, 10);
  });
  it("states how many bytes it needs", () => {
    expect(compile("b").size).toBe(1);
    expect(compile("w - b").size).toBe(2);
    expect(of("w", 1)).toBeNull();
  });
  it("has no value without enough bytes", () => {
    expect(of("1 / b", 0)).toBeNull();
  });
});

describe("errors and their positions", () => {
  it.each([
    ["", "empty", 0],
    ["b +", "end", 3],
    ["(b", "end", 2],
    ["b)", "sign", 1],
    ["b $ 2", "sign", 2],
    ["alert", "name", 0],
    ["constructor", "name", 0],
    ["b constructor 2", "sign", 2],
    ["b b", "sign", 2],
    ["b".repeat(81), "long", 80],
    ["*", "sign", 0],
  ])("%s", (text, kind, at) => {
    try {
      compile(text);
    } catch (error) {
      expect(error).toBeInstanceOf(FormulaProblem);
      expect(error).toMatchObject({ kind, at });
      return;
    }
    throw new Error("accepted");
  });
});
