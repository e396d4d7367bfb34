import { describe, expect, it } from "vitest";
import { bytesOf, readsFor, restored, valueOf, type Cell } from "./cells";

const cell = (address: number, formula = "b", space: Cell["space"] = "ram"): Cell => ({
  id: `${space}${address}`,
  space,
  address,
  name: "",
  formula,
  unit: "",
});

describe("watched cells", () => {
  it("that are near are read with one request", () => {
    const reads = readsFor([cell(0x50), cell(0x10, "w"), cell(0x14), cell(0x10, "b", "xram")]);
    expect(reads.map(({ space, address, count }) => [space, address, count])).toEqual([
      ["ram", 0x10, 5],
      ["ram", 0x50, 1],
      ["xram", 0x10, 1],
    ]);
  });
  it("of SFR are read byte by byte", () => {
    expect(readsFor([cell(0x80, "b", "sfr"), cell(0x81, "b", "sfr")])).toHaveLength(2);
  });
  it("have their own bytes and value", () => {
    const two = cell(0x12, "w / 10");
    const [read] = readsFor([cell(0x10), two]);
    const data = Uint8Array.of(9, 0, 0x64, 0x00);
    expect(bytesOf(two, read!, data)).toEqual(Uint8Array.of(0x64, 0));
    expect(valueOf(two, bytesOf(two, read!, data))).toBe(10);
  });
  it("end at the end of the space", () => {
    expect(readsFor([cell(0xff, "w")])[0]!.count).toBe(1);
    expect(valueOf(cell(0xff, "w"), Uint8Array.of(1))).toBeNull();
  });
  it("with an invalid formula have no value", () => {
    expect(valueOf(cell(0, "b +"), Uint8Array.of(1))).toBeNull();
  });
  it("are restored from damaged storage", () => {
    expect(restored(null)).toEqual([]);
    expect(restored("{")).toEqual([]);
    expect(restored("{}")).toEqual([]);
    const bad = [null, 1, { ...cell(1), space: "eeprom" }, { ...cell(1), address: 0x100 }, { ...cell(1), name: 1 }];
    expect(restored(JSON.stringify([...bad, cell(2)]))).toEqual([cell(2)]);
  });
});
