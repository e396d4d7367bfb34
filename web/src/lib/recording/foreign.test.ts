import { expect, it } from "vitest";
import { served } from "../platform/host";
import { loadSetting } from "../platform/storage";
import { Stores } from "../../stores";
import type { ForeignValues, RecordingDetail } from "../api/types";
import { decimalsOf, foreignLog, isForeign } from "./foreign";

const VALUES: ForeignValues = {
  format: "csv",
  names: ["FREQ", "Lambda"],
  units: ["rpm", ""],
  times: [100, 100.5, 101],
  values: [
    [850, null, 900],
    [1.01, 0.99, 0.985],
  ],
  rows: 3,
  decimated: false,
  started: null,
  marks: [{ time: 100.5, text: "knock" }],
  problems: [{ en: "one cell", ru: "одна ячейка" }],
};
const FILE = { name: "wideband.csv", size: 99 };

it("columns keep their names and units, and none is a channel of ours", () => {
  const { channels, columns, detail, remarks } = foreignLog(FILE, VALUES, [null, "λ"]);
  expect(channels.map(({ text, unit }) => [text.ru, unit.en])).toEqual([
    ["FREQ", "rpm"],
    ["Lambda", "λ"],
  ]);
  expect(channels.every(({ name }) => isForeign(name))).toBe(true);
  expect(isForeign("FREQ")).toBe(false);
  expect(columns.column("FREQ")).toBeUndefined();
  expect([...columns.column("log:FREQ")!]).toEqual([850, NaN, 900]);
  expect([detail.id, detail.first, detail.last, detail.samples]).toEqual(["wideband.csv", 100, 101, 3]);
  expect(detail.events).toEqual([{ kind: "marker", time: 100.5, label: "knock" }]);
  expect(remarks).toHaveLength(1);
});

it("numbers have the decimals of the file", () => {
  expect(decimalsOf([1, 2, null])).toBe(0);
  expect(decimalsOf([1.01, 0.985])).toBe(3);
  expect(decimalsOf([1 / 3])).toBe(4);
});

it("a log beside a recording has traces of its own, as long as it is shown", async () => {
  const stores = new Stores(served);
  const { catalog, comparison, player, view } = stores;
  player.detail = { id: "a.pcapng", first: 5000, last: 5010 } as RecordingDetail;
  const own = view.names;
  comparison.startForeign(foreignLog(FILE, VALUES), 5000);
  expect(comparison.active).toBe(true);
  expect(comparison.title).toBe("wideband.csv");
  expect(comparison.first + comparison.lag).toBe(5000);
  expect(view.names).toEqual([...own, "log:FREQ", "log:Lambda"]);
  expect(view.panes.at(-1)!.traces.map(({ name }) => name)).toEqual(["log:FREQ", "log:Lambda"]);
  expect(catalog.get("log:Lambda")?.decimals).toBe(3);
  expect(catalog.get("FREQ")).toBeUndefined();
  expect(catalog.channels).toEqual([]);
  await comparison.reload(); // there is nothing to ask the program for
  expect(comparison.detail?.id).toBe("wideband.csv");
  view.shift("log:Lambda", -1);
  expect(loadSetting("chart") ?? "").not.toContain("log:");
  comparison.end();
  expect(view.names).toEqual(own);
  expect(catalog.get("log:Lambda")).toBeUndefined();
  expect([comparison.active, comparison.remarks.length]).toEqual([false, 0]);
});

it("no trace of a log is asked of the unit", () => {
  const { catalog, comparison, subscriptions } = new Stores(served);
  comparison.startForeign(foreignLog(FILE, VALUES), 0);
  expect(catalog.get("log:FREQ")).toBeDefined();
  subscriptions.set("chart", ["log:FREQ"], false);
  expect(subscriptions.names).toEqual([]);
});
