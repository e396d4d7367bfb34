import { expect, it } from "vitest";
import { recomputed } from "./recomputed";
import type { Catalog } from "./types";

const channel = (name: string, formula: string, inputs: string[] | null = null, decimals = 0) => ({
  name,
  formula,
  inputs,
  decimals,
  constants: {},
  accumulates: false,
  code: null,
  size: null,
});
const catalog = (...derived: object[]) => ({ parameters: [channel("FREQ", "40·N")], derived }) as unknown as Catalog;

it("recomputed names changed, new and removed channels, and those that need them", () => {
  const before = catalog(
    channel("A", "FREQ", ["FREQ"]),
    channel("B", "A + 1", ["A"]),
    channel("GONE", "FREQ", ["FREQ"]),
    channel("C", "FREQ", ["FREQ"]),
  );
  const after = catalog(
    channel("A", "FREQ * 2", ["FREQ"]),
    channel("B", "A + 1", ["A"]),
    channel("NEW", "C", ["C"]),
    channel("C", "FREQ", ["FREQ"], 3),
  );
  expect(recomputed(before, after).sort()).toEqual(["A", "B", "GONE", "NEW"]);
  expect(recomputed(before, before)).toEqual([]);
});
