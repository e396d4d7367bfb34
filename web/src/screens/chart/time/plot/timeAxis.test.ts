import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { language } from "../../../../lib/i18n";
import { axisTimes, counted, elapsed, timesOfDay } from "./timeAxis";

describe("elapsed", () => {
  it("counts from the start in both directions", () => {
    expect([elapsed(0, 1), elapsed(65, 5), elapsed(-10, 10), elapsed(3720, 60)]).toEqual(["0:00", "1:05", "−0:10", "1:02:00"]);
  });

  it("has the decimals of its step, and never sixty seconds", () => {
    expect([elapsed(9.5, 0.5), elapsed(59.999, 0.01), elapsed(-0.0001, 0.1), elapsed(61.25, 0.05)]).toEqual([
      "0:09.5",
      "1:00.00",
      "0:00.0",
      "1:01.25",
    ]);
  });
});

describe("times in Russian", () => {
  it("have a comma before their decimals", () => {
    language.code = "ru";
    expect([elapsed(9.5, 0.5), elapsed(9.5, 1)]).toEqual(["0:09,5", "0:10"]);
    expect(timesOfDay([0.25], 0.1)[0]).toMatch(/:00,2$/);
    language.code = "en";
  });
});

describe("an axis that counts from a moment", () => {
  it("has labels at round times", () => {
    const axis = counted(1003.7);
    const splits = axis.splits(null, 0, 1000, 1020, 5);
    expect(splits).toEqual([1003.7, 1008.7, 1013.7, 1018.7]);
    expect(axis.values(null, splits, 0, 0, 5)).toEqual(["0:00", "0:05", "0:10", "0:15"]);
  });
});

describe("the labels of a picture's axis", () => {
  it("are few and round", () => {
    for (const length of [0.5, 7, 60, 3599, 40_000]) {
      const times = axisTimes(1_700_000_003.2, 1_700_000_003.2 + length, null);
      expect(times.length).toBeGreaterThan(2);
      expect(times.length).toBeLessThan(11);
    }
    expect(axisTimes(99, 161, 100).map(({ text }) => text)).toEqual(["0:00", "0:10", "0:20", "0:30", "0:40", "0:50", "1:00"]);
  });
});

it("has the labels that a plot in a notebook is held to as well (tests/notebook)", () => {
  const cases = JSON.parse(readFileSync(new URL("./timeAxis.test.json", import.meta.url), "utf8")) as {
    from: number;
    to: number;
    zero: number;
    labels: unknown;
  }[];
  for (const { from, to, zero, labels } of cases) expect(axisTimes(from, to, zero)).toEqual(labels);
});
