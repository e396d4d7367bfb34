import { beforeEach, describe, expect, it, vi } from "vitest";
import type { RecordingDetail } from "../api/types";
import { served } from "../platform/host";
import { Stores } from "../../stores";

const { api, comparison, player } = new Stores(served);

/** Two drives: the first from 5000 s on, the second, without THR, from 90 s on. */
const BEGAN: Record<string, number> = { first: 5000, second: 90 };
const times = (id: string) => Array.from({ length: 100 }, (_, row) => BEGAN[id]! + row / 10);

beforeEach(async () => {
  vi.stubGlobal("requestAnimationFrame", () => 1);
  vi.stubGlobal("cancelAnimationFrame", () => undefined);
  player.close();
  vi.spyOn(api, "recording").mockImplementation((id) =>
    Promise.resolve({
      id,
      first: BEGAN[id]! - 1,
      last: BEGAN[id]! + 9.9,
      samples: 100,
      rate: 10,
      events: [],
    } as unknown as RecordingDetail),
  );
  vi.spyOn(api, "rows").mockImplementation((id) => {
    const at = times(id);
    const names = id === "first" ? ["FREQ", "THR"] : ["FREQ"];
    return Promise.resolve({ names, times: at, values: names.map(() => at.map((_, row) => row)), decimated: false });
  });
  await player.open("first");
});

describe("a second recording", () => {
  it("starts where the first one does, whatever its clock", async () => {
    await comparison.start("second", player.first);
    expect(comparison.active).toBe(true);
    expect(comparison.first + comparison.lag).toBe(5000);
    expect(comparison.extremes("FREQ")).toEqual({ min: 0, max: 99 });
    expect(comparison.extremes("THR")).toBeUndefined();
  });

  it("is moved in exact tenths", async () => {
    await comparison.start("second", player.first);
    for (let step = 0; step < 13; step += 1) comparison.shift(0.1);
    expect(comparison.offset).toBe(1.3);
    expect(comparison.lag).toBeCloseTo(4911.3);
    comparison.moveTo(0);
    expect(comparison.lag).toBe(4910);
  });

  it("is aligned by a moment of its own and the same moment of the first one", async () => {
    await comparison.start("second", player.first);
    comparison.alignAt(5003);
    expect(comparison.offset).toBe(0);
    comparison.toggleAligning();
    comparison.alignAt(5003);
    expect(comparison.aligning).toEqual({ step: "first", at: 5003 });
    comparison.alignAt(5001.5);
    expect(comparison.offset).toBe(-1.5);
    expect(comparison.aligning).toBeNull();
  });

  it("is closed with the first one", async () => {
    await comparison.start("second", player.first);
    comparison.shift(2);
    player.close();
    expect([comparison.active, comparison.offset, comparison.columns.length]).toEqual([false, 0, 0]);
  });

  it("replaces one that is still loading", async () => {
    let answer: () => void = () => undefined;
    const slow = new Promise<void>((done) => (answer = done));
    const rows = vi.mocked(api.rows).getMockImplementation()!;
    vi.spyOn(api, "rows").mockImplementationOnce(async (id, query, signal) => {
      await slow;
      return rows(id, query, signal);
    });
    const asked = vi.mocked(api.rows).mock.calls.length;
    const before = comparison.start("first", player.first);
    await vi.waitFor(() => expect(vi.mocked(api.rows).mock.calls).toHaveLength(asked + 1));
    expect(await comparison.start("second", player.first)).toBe(true);
    answer();
    expect(await before).toBe(false);
    expect(comparison.detail?.id).toBe("second");
  });
});
