import { describe, expect, it } from "vitest";
import type { Recording } from "../../lib/api/types";
import { fileName, sheetText } from "../passport/sheet";
import { matching, newestFirst } from "./order";
import { faster, keyStep, nextLoop, precise, share, slower } from "./scrub";

const recording = (id: string, more: Partial<Recording> = {}): Recording => ({
  id,
  bytes: 0,
  date: null,
  length: null,
  model: null,
  passport: null,
  samples: 0,
  samples_exact: true,
  rate: 0,
  gaps: 0,
  faults: null,
  markers: 0,
  note: "",
  open: false,
  problem: null,
  ...more,
});

describe("the table", () => {
  const list = [recording("a", { date: 1 }), recording("b"), recording("c", { date: 3 })];
  it("has the newest first and the undated last", () => {
    expect(newestFirst(list).map((it) => it.id)).toEqual(["c", "a", "b"]);
    expect(list.map((it) => it.id)).toEqual(["a", "b", "c"]);
  });
  it("is searched by every word, in the note, the car and the faults", () => {
    const volga = recording("x", {
      note: "Волга, холодный пуск",
      model: { en: "Mikas 7.1", ru: "Микас 7.1" },
      faults: [53],
    });
    expect(matching([volga, ...list], "ВОЛГА микас")).toEqual([volga]);
    expect(matching([volga, ...list], "53")).toEqual([volga]);
    expect(matching(list, "  ")).toHaveLength(3);
    expect(matching([volga], "волга нет")).toEqual([]);
  });
});

describe("the player bar", () => {
  it("goes up and down its speeds and stays at the ends", () => {
    expect([faster(1), faster(16), slower(1), slower(0.25)]).toEqual([2, 16, 0.5, 0.25]);
  });
  it("places a time", () => {
    expect([share(5, 0, 10), share(-1, 0, 10), share(11, 0, 10), share(1, 1, 1)]).toEqual([
      0.5, 0, 1, 0,
    ]);
  });
  it("loops between two marks, in either order, and lets go at the third", () => {
    const one = nextLoop(null, 7);
    const two = nextLoop(one.loop, 3);
    expect(two.whole).toEqual({ from: 3, to: 7 });
    expect(nextLoop(two.loop, 5)).toEqual({ loop: null, whole: null });
    expect(nextLoop({ from: 3 }, 3)).toEqual({ loop: null, whole: null });
  });
  it("steps by the keys", () => {
    expect(keyStep("ArrowLeft", false)).toBe(-1);
    expect(keyStep("ArrowRight", true)).toBe(10);
    expect(keyStep("Home", false)).toBe("first");
    expect(keyStep("a", false)).toBeNull();
  });
  it("shows tenths without skipping to the sixtieth second", () => {
    expect([precise(0), precise(59.97), precise(65.25)]).toEqual(["00:00.0", "01:00.0", "01:05.3"]);
    expect([precise(0.021, 2), precise(59.999, 2), precise(65.25, 2)]).toEqual(["00:00.02", "01:00.00", "01:05.25"]);
  });
});

describe("the passport sheet", () => {
  it("aligns its columns", () => {
    expect(
      sheetText("T", [
        ["a", "1"],
        ["long", "2"],
      ]),
    ).toBe("T\n\na     1\nlong  2\n");
  });
  it("names a file with what a file system takes", () => {
    expect(fileName(["Mikas 7.1", null, "  ", "А/Б:1"], "json")).toBe("Mikas-7.1-А-Б-1.json");
    expect(fileName([null], "txt")).toBe("mikas.txt");
  });
});
