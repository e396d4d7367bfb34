import { expect, it } from "vitest";
import { withMarker } from "./recordingData.svelte";
import type { RecordingDetail } from "../api/types";

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
