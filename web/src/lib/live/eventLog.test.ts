import { describe, expect, it, vi } from "vitest";
import { EventLog } from "./eventLog";
import type { LineEvent } from "../api/types";

const reason = { en: "no answer", ru: "нет ответа" };
const gap = (began: number, ended: number | null): LineEvent => ({ kind: "gap", time: ended ?? began, began, ended, reason });
const dropped = (time: number): LineEvent => ({ kind: "dropped", time, name: "X" });
const marker = (time: number): LineEvent => ({ kind: "marker", time, label: "" });

/** The events after these batches were added. */
function added(...batches: LineEvent[][]): readonly LineEvent[] {
  const log = new EventLog();
  return batches.map((batch) => log.add(batch)).at(-1)!;
}

describe("EventLog", () => {
  it("orders events and drops repeated ones", () => {
    expect(added([marker(1), marker(5)], [marker(5), marker(3)]).map(({ time }) => time)).toEqual([1, 3, 5]);
    expect(added([marker(5), marker(5), marker(1)])).toEqual([marker(1), marker(5)]);
  });

  it("replaces an open gap by the ended one, never the reverse", () => {
    expect(added([gap(2, null)], [marker(3)], [gap(2, 4)])).toEqual([gap(2, 4), marker(3)]);
    expect(added([gap(2, null)], [gap(2, 4)], [gap(2, null)])).toEqual([gap(2, 4)]);
  });

  it("gives a marker another name", () => {
    const named: LineEvent = { kind: "marker", time: 2, label: "knock" };
    expect(added([marker(2), marker(3)], [named])).toEqual([named, marker(3)]);
  });

  it("drops a removed marker, which may come back", () => {
    const removed: LineEvent = { kind: "marker", time: 2, label: "", removed: true };
    expect(added([marker(1), marker(2), marker(3)], [removed, removed])).toEqual([marker(1), marker(3)]);
    expect(added([removed])).toEqual([]);
    expect(added([marker(2), marker(3)], [removed], [marker(2)])).toEqual([marker(2), marker(3)]);
  });

  it("returns a new list and leaves the previous one unchanged", () => {
    const log = new EventLog();
    const before = log.add([marker(1)]);
    expect(log.add([marker(2)])).not.toBe(before);
    expect(before).toEqual([marker(1)]);
  });

  it("keeps the latest events", () => {
    const log = new EventLog();
    log.add(Array.from({ length: 2000 }, (_, time) => marker(time)));
    expect(log.add([marker(2000)]).map(({ time }) => time)).toEqual(Array.from({ length: 2000 }, (_, at) => at + 1));
    expect(log.add([marker(0)]).at(0)).toEqual(marker(1));
  });

  it("adds an event without sorting or comparing the others", () => {
    const log = new EventLog();
    log.add(Array.from({ length: 1500 }, (_, time) => marker(time)));
    const stringify = vi.spyOn(JSON, "stringify");
    const sort = vi.spyOn(Array.prototype, "sort");
    log.add([dropped(1500)]);
    expect([stringify.mock.calls.length, sort.mock.calls.length]).toEqual([1, 0]);
    vi.restoreAllMocks();
  });
});
