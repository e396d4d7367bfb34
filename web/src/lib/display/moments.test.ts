import { beforeEach, describe, expect, it } from "vitest";
import { language } from "../i18n";
import { bandsOf } from "./moments.svelte";
import { served } from "../platform/host";
import { Stores } from "../../stores";

const { cursors, moments } = new Stores(served);

const list = [
  { from: 1, to: 2 },
  { from: 5, to: 5 },
  { from: 9, to: 12 },
];

describe("moments", () => {
  beforeEach(() => {
    cursors.a = cursors.b = null;
    moments.clear();
  });

  it("are visited in both directions, the cursor with them", () => {
    moments.mark(() => "x", list);
    const visited = ([1, 1, 1, -1] as const).map((step) => (moments.turn(step), cursors.a));
    expect(visited).toEqual([5, 9, 1, 9]);
  });

  it("leave a selection as it is", () => {
    cursors.a = 3;
    cursors.b = 7;
    moments.mark(() => "x", list);
    moments.turn(1);
    expect([cursors.between, moments.current]).toEqual([[3, 7], list[1]]);
  });

  it("are titled in the language of now", () => {
    moments.mark(() => language.code, list);
    language.code = "ru";
    expect(moments.title()).toBe("ru");
    language.code = "en";
    expect(moments.title()).toBe("en");
  });

  it("may be none", () => {
    moments.mark(() => "x", []);
    moments.turn(1);
    moments.turn(-1);
    expect([moments.current, cursors.a]).toEqual([undefined, null]);
  });

  it("are bands in a window, close ones joined", () => {
    expect(bandsOf(list, 2, 9, 0.5)).toEqual(list);
    expect(bandsOf(list, 2.5, 8, 0.5)).toEqual([list[1]]);
    expect(bandsOf(list, 0, 20, 3.5)).toEqual([
      { from: 1, to: 5 },
      { from: 9, to: 12 },
    ]);
    expect(list[0]).toEqual({ from: 1, to: 2 });
  });
});
