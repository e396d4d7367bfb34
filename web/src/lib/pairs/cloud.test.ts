import { describe, expect, it } from "vitest";
import { Columns } from "../series/columns";
import { Cloud, paint, shareOf, type Inks } from "./cloud";
import { colourAt, packed, packedHex, rampOf } from "./colours";
import { Pairs } from "./pairs";
import { randoms } from "../../../test/random";

function pairsOf(points: readonly (readonly [number, number, number | null])[]): Pairs {
  const columns = new Columns();
  columns.append(
    ["Y", "X", "C"],
    points.map((_, at) => at),
    [1, 0, 2].map((at) => points.map((point) => point[at]!)),
  );
  const pairs = new Pairs({
    name: "Y",
    partners: [
      { name: "X", needed: true },
      { name: "C", needed: false },
    ],
    age: 0,
    span: null,
  });
  while (pairs.read(columns, [], 1000));
  return pairs;
}

const inks: Inks = { ramp: Uint32Array.from([1, 2, 3]), low: 0, high: 10, plain: 9, density: false, side: 1 };

describe("the cloud", () => {
  it("counts each point at its pixel, in any portions, and those outside", () => {
    const next = randoms(3);
    const points = Array.from({ length: 3000 }, () => [12 * next(), 12 * next(), next() < 0.2 ? null : 10 * next()] as const);
    const pairs = pairsOf(points);
    const cloud = new Cloud(11, 11, { x: [0, 10], y: [0, 10] });
    while (cloud.take(pairs, 77));
    const naive = new Map<number, number>();
    let outside = 0;
    for (const [x, y] of points) {
      if (Math.round(x) > 10 || Math.round(10 - y) < 0) outside += 1;
      else naive.set(Math.round(10 - y) * 11 + Math.round(x), (naive.get(Math.round(10 - y) * 11 + Math.round(x)) ?? 0) + 1);
    }
    expect(cloud.outside).toBe(outside);
    expect([...cloud.count].map((count, at) => [at, count]).filter(([, count]) => count)).toEqual(
      [...naive].sort(([one], [other]) => one - other),
    );
  });

  it("shows the mean of a pixel's colour values, and points without one apart", () => {
    const cloud = new Cloud(3, 3, { x: [0, 2], y: [0, 2] });
    cloud.take(
      pairsOf([
        [0, 0, 0],
        [0, 0, 10],
        [1, 1, null],
        [2, 2, 10],
        [2, 2, null],
      ]),
      10,
    );
    const pixels = new Uint32Array(9);
    paint(cloud, pixels, inks);
    expect([...pixels]).toEqual([0, 0, 3, 0, 9, 0, 2, 0, 0]);
  });

  it("may use the memory of another one, without its points", () => {
    const pairs = pairsOf([
      [0, 0, 5],
      [2, 1, 7],
    ]);
    const before = new Cloud(3, 3, { x: [0, 2], y: [0, 2] });
    before.take(
      pairsOf([
        [1, 1, 3],
        [0, 0, 9],
        [2, 2, 1],
      ]),
      10,
    );
    const [reused, fresh] = [new Cloud(3, 3, { x: [0, 2], y: [0, 2] }, before), new Cloud(3, 3, { x: [0, 2], y: [0, 2] })];
    for (const cloud of [reused, fresh]) cloud.take(pairs, 10);
    expect([reused.count, reused.coloured, reused.sum, reused.used]).toEqual([fresh.count, fresh.coloured, fresh.sum, 2]);
    expect(new Cloud(2, 2, fresh.frame, fresh).count).toHaveLength(4);
  });

  it("draws squares that end at the edge", () => {
    const cloud = new Cloud(4, 4, { x: [0, 3], y: [0, 3] });
    cloud.take(pairsOf([[0, 0, 0]]), 10);
    const pixels = new Uint32Array(16);
    paint(cloud, pixels, { ...inks, side: 3 });
    expect([...pixels].flatMap((ink, at) => (ink ? [at] : []))).toEqual([8, 9, 12, 13]);
  });

  it("finds the nearest point within reach, and those in a polygon", () => {
    const pairs = pairsOf([
      [1, 1, 0],
      [5, 5, 0],
      [9, 1, 0],
    ]);
    const cloud = new Cloud(101, 101, { x: [0, 10], y: [0, 10] });
    cloud.take(pairs, 10);
    expect([cloud.nearest(pairs, 48, 53, 10), cloud.nearest(pairs, 30, 30, 10), cloud.nearest(pairs, 91, 91, 10)]).toEqual([1, -1, 2]);
    expect(
      cloud.inside(pairs, [
        [0, 40],
        [60, 40],
        [60, 101],
        [0, 101],
      ]),
    ).toEqual([0, 1]);
  });
});

describe("colours", () => {
  it("change their lightness in one direction", () => {
    for (const tone of ["night", "day"] as const) {
      const light = Array.from({ length: 21 }, (_, at) => colourAt(tone, at / 20)).map(
        ([red, green, blue]) => 0.2126 * red + 0.7152 * green + 0.0722 * blue,
      );
      expect(light.every((it, at) => at === 0 || (tone === "night" ? it > light[at - 1]! : it < light[at - 1]!))).toBe(true);
    }
    expect(rampOf("day")[0]).toBe(packed(colourAt("day", 0)));
    expect(packedHex("#ff8000")).toBe(0xff0080ff);
  });

  it("take the middle where there is no range", () => {
    expect([shareOf(3, 3, 3), shareOf(-1, 0, 4), shareOf(1, 0, 4), shareOf(9, 0, 4)]).toEqual([0.5, 0, 0.25, 1]);
  });
});
