import { describe, expect, it, vi } from "vitest";
import { RecordingData, withMarker } from "./recordingData.svelte";
import { ApiError } from "../api/http";
import type { RecordingDetail, RecordingRows } from "../api/types";
import { served } from "../platform/host";
import { Stores } from "../../stores";

const { api } = new Stores(served);

type RecordedEvent = RecordingDetail["events"][number];
const marker = (time: number, label = ""): RecordedEvent => ({ kind: "marker", time, label });
const dropped: RecordedEvent = { kind: "dropped", time: 2, name: "X" };

it("a marker is named, removed and brought back in its place", () => {
  const events = [marker(1), dropped, marker(3)];
  expect(withMarker(events, 1, "knock")).toEqual([marker(1, "knock"), dropped, marker(3)]);
  expect(withMarker(events, 1, null)).toEqual([dropped, marker(3)]);
  expect(withMarker([dropped, marker(3)], 1, "a")).toEqual([marker(1, "a"), dropped, marker(3)]);
  expect(withMarker([dropped], 3, "")).toEqual([dropped, marker(3)]);
});

describe("a recording that is shown", () => {
  class Shown extends RecordingData {
    open = (id: string) => this.load(id);
  }
  const detail = { id: "a.pcapng", first: 1, last: 3, samples: 3, rate: 1, events: [] } as unknown as RecordingDetail;
  const rows = (value: number) =>
    ({ names: ["A"], times: [1, 2, 3], values: [[value, value, value]], decimated: false }) as unknown as RecordingRows;
  const shown = ({ columns }: RecordingData) => columns.column("A")?.[0];

  async function opened() {
    vi.spyOn(api, "recording").mockResolvedValue(detail);
    const answers: { resolve: (rows: RecordingRows) => void; reject: (error: Error) => void }[] = [];
    const found = vi.spyOn(api, "rows").mockResolvedValueOnce(rows(1));
    const data = new Shown(api);
    await data.open("a.pcapng");
    found.mockImplementation(() => new Promise((resolve, reject) => void answers.push({ resolve, reject })));
    return { data, answers };
  }

  it("has the car that was written into it", async () => {
    const { data } = await opened();
    const car = { car: "Волга", plate: "", mileage: null, workshop: "" };
    data.described("other.pcapng", car);
    expect(data.detail?.car).toBeUndefined();
    data.described("a.pcapng", car);
    expect(data.detail?.car).toBe(car);
  });

  it("that is loaded again is shown as before until the new values are there", async () => {
    const { data, answers } = await opened();
    const again = data.reload();
    await vi.waitFor(() => expect(answers.length).toBe(1));
    expect([data.detail?.id, shown(data)]).toEqual(["a.pcapng", 1]);
    answers[0]!.resolve(rows(2));
    await again;
    expect([shown(data), data.loaded]).toEqual([2, 1]);
  });

  it("that can't be loaded again is shown as before, with the error", async () => {
    const { data, answers } = await opened();
    const again = data.reload();
    await vi.waitFor(() => expect(answers.length).toBe(1));
    answers[0]!.reject(new ApiError(503, "Busy", { en: "busy", ru: "занято" }));
    await expect(again).rejects.toThrow("busy");
    expect([data.detail?.id, shown(data), data.error?.code]).toEqual(["a.pcapng", 1, "Busy"]);
  });

  it("that is loaded again twice has the values of the last change", async () => {
    const { data, answers } = await opened();
    const both = [data.reload(), data.reload()];
    await vi.waitFor(() => expect(answers.length).toBe(1));
    answers[0]!.resolve(rows(3));
    await Promise.all(both);
    expect(shown(data)).toBe(3);
  });
});
