import { describe, expect, it } from "vitest";
import { SPACES, addressText, character, dumpText, fromHex, parseAddress, parseBytes, rowsOf, spaceOf, spaced, toHex } from "./hex";

describe("addresses", () => {
  it.each([
    ["1F", 0x1f],
    ["0x1f", 0x1f],
    ["1Fh", 0x1f],
    [" ffff ", 0xffff],
    ["0", 0],
  ])("%s", (text, value) => {
    expect(parseAddress(text)).toBe(value);
  });
  it.each(["", "x", "0x", "12 34", "-1", "1.5", "12345678"])("%s is none", (text) => {
    expect(parseAddress(text)).toBeNull();
  });
  it("have as many digits as their space needs", () => {
    expect(addressText(0x0a, spaceOf("ram"))).toBe("0A");
    expect(addressText(0x0a, spaceOf("code"))).toBe("000A");
  });
});

describe("bytes", () => {
  it.each([
    ["0AFF", [10, 255]],
    ["0a ff", [10, 255]],
    ["0A:FF", [10, 255]],
    ["0x0A, 0xFF", [10, 255]],
    ["1 2", [1, 2]],
  ])("%s", (text, value) => {
    expect([...(parseBytes(text) ?? [])]).toEqual(value);
  });
  it.each(["", "  ", "G0", "123", "0A FFF"])("“%s” is none", (text) => {
    expect(parseBytes(text)).toBeNull();
  });
  it("convert to hex and back", () => {
    const all = Uint8Array.from({ length: 256 }, (_, at) => at);
    expect(fromHex(toHex(all))).toEqual(all);
    expect(parseBytes(toHex(all))).toEqual(all);
    expect(spaced(all.subarray(9, 12))).toBe("09 0A 0B");
    expect(spaced(all, 2)).toBe("00 01 … (256)");
  });
});

describe("rows", () => {
  it("begin at multiples of sixteen, with gaps where there is no byte", () => {
    const rows = rowsOf(Uint8Array.of(1, 2, 3), 0x1e);
    expect(rows.map((row) => row.address)).toEqual([0x10, 0x20]);
    expect(rows[0]!.cells.slice(13)).toEqual([null, 1, 2]);
    expect(rows[1]!.cells.slice(0, 2)).toEqual([3, null]);
  });
  it("are sixteen for 256 bytes, at every start", () => {
    for (let first = 0; first < 32; first++) {
      const data = Uint8Array.from({ length: 256 }, (_, at) => at);
      const flat = rowsOf(data, first)
        .flatMap((row) => row.cells)
        .filter((cell) => cell !== null);
      expect(flat).toEqual([...data]);
    }
  });
  it("are formatted as by mikas mem read", () => {
    expect(dumpText(Uint8Array.of(0x8c, 0xa8, 0x41), 0x40, "cp866")).toBe(`0040  8C A8 41${" ".repeat(15)}  ${" ".repeat(23)}  МиA`);
  });
});

it("characters are those of code page 866, or of ASCII alone", () => {
  expect([0x41, 0x8c, 0x00, 0x0d, 0x7f, 0xff].map((it) => character(it, "cp866")).join("")).toBe("AМ····");
  expect(character(0x8c, "ascii")).toBe("·");
});

it("the spaces have the ends of the protocol", () => {
  expect(SPACES.map((it) => it.last)).toEqual([0xff, 0xffff, 0xffff, 0xff]);
});
