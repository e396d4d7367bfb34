import { expect, it } from "vitest";
import { markersOf, nextMark } from "./markers.svelte";

const marks = [10, 20, 30].map((time) => ({ time, label: `${time}` }));

it("the next and the previous marker, around the ends", () => {
  expect([5, 10, 25, 30].map((time) => nextMark(marks, time, 1)!.time)).toEqual([10, 20, 30, 10]);
  expect([35, 30, 25, 10].map((time) => nextMark(marks, time, -1)!.time)).toEqual([30, 20, 20, 30]);
  expect(nextMark([], 5, 1)).toBeUndefined();
});

it("markers are the events of that kind, by time", () => {
  const marker = (time: number) => ({ kind: "marker" as const, time, label: "" });
  expect(markersOf([marker(3), { kind: "dropped", time: 2, name: "X" }, marker(1)]).map(({ time }) => time)).toEqual([1, 3]);
});
