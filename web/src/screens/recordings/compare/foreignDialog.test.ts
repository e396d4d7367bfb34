import { expect, test, vi } from "vitest";
import { ApiError } from "../../../lib/api/http";
import type { ForeignPreview, ForeignValues } from "../../../lib/api/types";
import { ForeignDialog, MOST_BYTES } from "./foreignDialog.svelte";

const column = (name: string, ...samples: string[]) => ({ name, unit: "", samples });
const CSV: ForeignPreview = {
  format: "csv",
  columns: [column("t", "0", "40"), column("AFR", "14,7", ""), column("gear", "R", "1")],
  layout: { encoding: "utf-8", delimiter: ";", decimal: ",", names_line: 1, units_line: 0, time: null, time_unit: null },
};
const MLG: ForeignPreview = { format: "mlg", columns: [column("RPM"), column("AFR")], layout: null };
const FILE = new File(["t;AFR"], "log.csv");

function dialog(found: ForeignPreview) {
  const foreignPreview = vi.fn(() => Promise.resolve(found));
  const foreignValues = vi.fn(() =>
    Promise.resolve<ForeignValues>({
      ...{ format: "csv", names: ["AFR"], units: [""], times: [0], values: [[14.7]], rows: 1 },
      ...{ decimated: false, started: null, marks: [], problems: [] },
    }),
  );
  return { foreignPreview, foreignValues, opened: new ForeignDialog({ foreignPreview, foreignValues }, FILE) };
}

test("waits for a person where the file leaves it open", async () => {
  const { opened: it, foreignValues } = dialog(CSV);
  expect(it.ready).toBe(false);
  await it.look();
  expect([it.time, it.timeUnit, it.ready]).toEqual([null, null, false]);
  it.chooseTime(0);
  expect(it.ready).toBe(false);
  it.timeUnit = "ms";
  expect(it.ready).toBe(true);
  expect(it.offered.map(({ name }) => name)).toEqual(["AFR", "gear"]);
  expect(it.chosen.map(({ name }) => name)).toEqual(["AFR"]);
  it.units[1] = " λ ";
  const log = await it.read();
  expect(foreignValues.mock.lastCall).toEqual([
    FILE,
    { encoding: null, delimiter: null, decimal: null, names_line: null, units_line: null, time: 0, time_unit: "ms", columns: "1" },
  ]);
  expect(log?.channels[0]!.unit.en).toBe("λ");
  it.toggle(1);
  expect(it.ready).toBe(false);
  it.toggleAll();
  expect(it.chosen).toHaveLength(2);
  it.toggleAll();
  expect(it.chosen).toHaveLength(0);
});

test("begins with what the file says, and looks again where a setting is another one", async () => {
  const says = { ...CSV, layout: { ...CSV.layout!, time: 0, time_unit: "s" } };
  const { opened: it, foreignPreview } = dialog(says);
  await it.look();
  expect([it.time, it.timeUnit, it.ready]).toEqual([0, "s", true]);
  it.chooseTime(1);
  expect(it.timeUnit).toBeNull();
  it.chooseTime(0);
  expect(it.timeUnit).toBe("s");
  await it.set({ delimiter: "|" });
  expect(foreignPreview.mock.lastCall).toEqual([FILE, { ...it.settings, delimiter: "|" }]);
});

test("has no time to choose in a log that knows its own", async () => {
  const { opened: it, foreignValues } = dialog(MLG);
  await it.look();
  expect(it.ready).toBe(true);
  expect(it.offered).toHaveLength(2);
  await it.read();
  expect(foreignValues.mock.lastCall![1 as never]).toMatchObject({ time: null, time_unit: null, columns: "0,1" });
});

test("stays with the error of a file that can't be read", async () => {
  const { opened: it, foreignValues } = dialog(MLG);
  await it.look();
  const text = { en: "log.mlg, byte 22: damaged", ru: "log.mlg, байт 22: повреждён" };
  foreignValues.mockRejectedValueOnce(new ApiError(400, "ForeignLogError", text));
  expect(await it.read()).toBeUndefined();
  expect(it.reading.error?.text).toEqual(text);
});

test("a file that the program would refuse is known before it is sent, and a binary one by its name", () => {
  const at = (name: string, bytes: number) => {
    const file = new File([], name);
    Object.defineProperty(file, "size", { value: bytes });
    return new ForeignDialog({ foreignPreview: vi.fn(), foreignValues: vi.fn() }, file);
  };
  expect([at("log.csv", MOST_BYTES).tooLarge, at("log.csv", MOST_BYTES + 1).tooLarge]).toEqual([false, true]);
  expect([at("log.MLG", 1).binary, at("log.mf4", 1).binary, at("mlg.csv", 1).binary]).toEqual([true, true, false]);
});
