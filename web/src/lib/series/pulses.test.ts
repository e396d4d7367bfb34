import { expect, it } from "vitest";
import { Columns } from "./columns";
import { PulseCounter, sinceSet } from "./pulses";

const filled = (...values: (boolean | null)[]) => {
  const columns = new Columns();
  columns.append(
    ["DET"],
    values.map((_, row) => row),
    [values],
  );
  return columns;
};

it("counts how often a flag became set, each row once, and over rows without a value", () => {
  const columns = filled(false, true, true, null, true, false, true);
  const counter = new PulseCounter();
  expect(counter.read(columns, "DET")).toEqual({ count: 2, last: 6, atLeast: false });
  columns.append(["DET"], [7, 8, 9], [[true, false, true]]);
  expect(counter.read(columns, "DET")).toEqual({ count: 3, last: 9, atLeast: false });
  expect(counter.read(columns, "DET").count).toBe(3);
});

it("counts nothing before its beginning, and goes on after the columns were emptied", () => {
  const columns = filled(true, false, true, false);
  const counter = new PulseCounter(1.5);
  expect(counter.read(columns, "DET").count).toBe(1);
  columns.clear();
  columns.append(["DET"], [10, 11], [[false, true]]);
  expect(counter.read(columns, "DET")).toEqual({ count: 2, last: 11, atLeast: false });
  expect(new PulseCounter().read(columns, "RDET")).toEqual({ count: 0, last: null, atLeast: false });
});

it("holds a flag for three seconds", () => {
  const columns = filled(true, false, false, false, false);
  expect(sinceSet(columns, "DET", 0)).toBe(0);
  expect(sinceSet(columns, "DET", 2.5)).toBe(2.5);
  expect(sinceSet(columns, "DET", 3)).toBeNull();
  expect(sinceSet(columns, "RDET", 1)).toBeNull();
});
