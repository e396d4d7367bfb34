import { expect, it } from "vitest";
import { drawingOf, roundStep } from "./way";

const [LAPTOP, PHONE] = [900, 366];

const line = (east: number[], north: number[], level: number | null = 0) => ({ level, east, north });

it.each([LAPTOP, PHONE])("one scale for both directions, north above, all within the drawing of %i pixels", (width) => {
  const lines = [line([0, 1000], [0, 0]), line([1000, 1000], [0, 500], 3)];
  const { paths, height, begin, end } = drawingOf({ lines }, width);
  const [first, second] = paths.map(({ d }) =>
    d
      .slice(1)
      .split("L")
      .map((place) => place.split(" ").map(Number)),
  );
  expect(first![1]![0]! - first![0]![0]!).toBeCloseTo(2 * (second![0]![1]! - second![1]![1]!), 0);
  expect(second![1]![1]!).toBeLessThan(second![0]![1]!);
  for (const [x, y] of [...first!, ...second!]) {
    expect(x).toBeGreaterThan(0);
    expect(x).toBeLessThan(width);
    expect(y).toBeGreaterThan(0);
    expect(y).toBeLessThan(height - 20);
  }
  expect(begin).toEqual(first![0]);
  expect(end).toEqual(second![1]);
  expect(paths.map(({ level }) => level)).toEqual([0, 3]);
});

it.each([LAPTOP, PHONE])("a cell of the grid is a round number of metres, and five to thirteen are on %i pixels", (width) => {
  for (const metres of [3, 60, 777, 4000, 123_456]) {
    const { step, side, columns } = drawingOf({ lines: [line([0, metres], [0, metres / 3])] }, width);
    expect(String(step)).toMatch(/^[125]0*$/);
    expect(columns[0]).toBe(side);
    expect(width / side).toBeGreaterThanOrEqual(5);
    expect(width / side).toBeLessThanOrEqual(13);
  }
  expect([0.9, 1, 4.9, 5, 99].map(roundStep)).toEqual([0.5, 1, 2, 5, 50]);
});

it("a car that stands is a point in a drawing of fifty metres", () => {
  const { paths, step } = drawingOf({ lines: [line([0, 0], [0, 0])] }, PHONE);
  expect(step).toBe(10);
  expect(paths[0]!.d).not.toContain("NaN");
});
