import { expect, it } from "vitest";
import { lineOf, momentIn, ordered } from "./freezeFrame";

const rows = {
  names: ["TWAT", "FREQ"],
  times: [0, 1, 2, 10],
  values: [
    [80, 90, null, 100],
    [null, 850, null, null],
  ],
};

it("draws a channel over the whole frame, interrupted where values are missing", () => {
  expect(lineOf(rows, "TWAT")).toEqual({ path: "M0.00 28.00L10.00 15.00M100.00 2.00", low: 80, high: 100 });
  expect(lineOf(rows, "FREQ")).toBeNull();
  expect(lineOf(rows, "UOZ")).toBeNull();
});

it("gives a constant line the middle of its least span", () => {
  const line = lineOf({ names: ["A"], times: [0, 1], values: [[5, 5]] }, "A", 10);
  expect(line).toEqual({ path: "M0.00 15.00L100.00 15.00", low: 5, high: 5 });
});

it("knows where the moment lies, and shows related channels first", () => {
  expect(momentIn(rows, { without: 5, seen: 6 })).toEqual([50, 60]);
  const value = (name: string) => ({ name, value: 1, low: 1, high: 1 });
  expect(ordered([value("A"), value("B"), value("C")], ["C", "B"]).map(({ name }) => name)).toEqual(["C", "B", "A"]);
});
