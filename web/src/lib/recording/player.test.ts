import { beforeEach, describe, expect, it, vi } from "vitest";
import { advance } from "./player.svelte";
import type { RecordingDetail } from "../api/types";
import { served } from "../platform/host";
import { Stores } from "../../stores";

const { api, display, player } = new Stores(served);

const RATE = 50;
const SAMPLES = 40_000;
const FIRST = 5000;

const times = Array.from({ length: SAMPLES }, (_, row) => FIRST + row / RATE);
const detail = {
  id: "a.pcapng",
  first: FIRST,
  last: times[SAMPLES - 1]!,
  samples: SAMPLES,
  rate: RATE,
  events: [],
  channels: ["FREQ"],
} as unknown as RecordingDetail;

/** As the server answers: every row, or its first and last of each stretch when there are more than points. */
function rows(_: string, { from, to, points }: { from: number | null; to: number | null; points: number }) {
  const inside = times.filter((time) => time >= from! && time <= to!);
  const decimated = inside.length > points;
  const kept = decimated ? inside.filter((_, row) => row % Math.ceil(inside.length / points) === 0) : inside;
  return Promise.resolve({ names: ["FREQ"], times: kept, values: [kept.map((time) => Math.round((time - FIRST) * RATE))], decimated });
}

beforeEach(() => {
  vi.stubGlobal("requestAnimationFrame", () => 1);
  vi.stubGlobal("cancelAnimationFrame", () => undefined);
  player.close();
  vi.spyOn(api, "recording").mockResolvedValue(detail);
  vi.spyOn(api, "rows").mockImplementation(rows);
});

describe("the player", () => {
  it("shows an overview at once and then every row", async () => {
    await player.open("a.pcapng");
    expect(display.source).toBe(player);
    expect(player.columns.length).toBeGreaterThan(100);
    expect(player.columns.length).toBeLessThan(SAMPLES);
    await vi.waitFor(() => expect(player.loaded).toBe(1));
    expect(player.columns.length).toBe(SAMPLES);
    expect(player.extremes("FREQ")).toEqual({ min: 0, max: SAMPLES - 1 });
  });

  it("starts at the first sample, not at the first byte", async () => {
    vi.spyOn(api, "recording").mockResolvedValue({ ...detail, first: FIRST - 3 });
    await player.open("a.pcapng");
    expect(player.position).toBe(FIRST);
    expect(player.latest("FREQ")?.value).toBe(0);
    player.seek(0);
    expect(player.position).toBe(FIRST);
  });

  it("steps by samples, seeks within the recording, and returns the value at its position", async () => {
    await player.open("a.pcapng");
    await vi.waitFor(() => expect(player.loaded).toBe(1));
    player.seek(FIRST + 10);
    expect(player.latest("FREQ")?.value).toBe(500);
    player.step(1);
    expect(player.latest("FREQ")?.value).toBe(501);
    player.step(-2);
    expect(player.latest("FREQ")?.value).toBe(499);
    player.seek(0);
    expect(player.position).toBe(FIRST);
    player.seek(1e9);
    expect(player.position).toBe(detail.last);
    expect(player.latest("NONE")).toBeUndefined();
  });

  it("returns to live data", async () => {
    await player.open("a.pcapng");
    player.close();
    expect(display.source.kind).toBe("live");
    expect(player.columns.length).toBe(0);
  });
});

describe("advance", () => {
  it("ends at the end of the recording", () => {
    expect(advance(1, 2, 10, null)).toBe(3);
    expect(advance(9, 2, 10, null)).toBe(10);
  });

  it("stays in the loop at any speed", () => {
    const loop = { from: 2, to: 4 };
    expect(advance(3.5, 1, 10, loop)).toBeCloseTo(2.5);
    expect(advance(3.5, 4, 10, loop)).toBeCloseTo(3.5);
    expect(advance(7, 1, 10, loop)).toBe(8);
  });
});
