import { describe, expect, it } from "vitest";
import type { Recording } from "../api/types";
import { matching, newestFirst } from "./order";

const recording = (id: string, more: Partial<Recording> = {}): Recording => ({
  id,
  car: { car: "", plate: "", mileage: null, workshop: "" },
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
  reference: false,
  virtual: false,
  clock: [],
  problem: null,
  ...more,
});

describe("the list", () => {
  const list = [recording("a", { date: 1 }), recording("b"), recording("c", { date: 3 })];
  it("is ordered newest first, undated last", () => {
    expect(newestFirst(list).map((it) => it.id)).toEqual(["c", "a", "b"]);
    expect(list.map((it) => it.id)).toEqual(["a", "b", "c"]);
  });
  it("is searched by every word in note, car and faults", () => {
    const volga = recording("x", { note: "Волга, холодный пуск", model: { en: "Mikas 7.1", ru: "Микас 7.1" }, faults: [53] });
    expect(matching([volga, ...list], "ВОЛГА микас")).toEqual([volga]);
    expect(matching([volga, ...list], "53")).toEqual([volga]);
    expect(matching(list, "  ")).toHaveLength(3);
    expect(matching([volga], "волга нет")).toEqual([]);
  });
});
