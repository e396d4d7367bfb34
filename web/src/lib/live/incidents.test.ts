import { expect, it } from "vitest";
import { incidents } from "./incidents";
import type { LineEvent } from "../api/types";

const both = (text: string) => ({ en: text, ru: `по-русски ${text}` });
const gap = (began: number, ended: number | null, reason: string): LineEvent => ({
  kind: "gap",
  time: ended ?? began,
  began,
  ended,
  reason: both(reason),
});
const error = (time: number, text: string, sent = "0102", received: string | null = "0A1B"): LineEvent => ({
  kind: "error",
  time,
  code: "E",
  text: both(text),
  sent,
  received,
});

it("shows an error that caused a gap once, with the gap", () => {
  const reason = "damaged (sent 01 02, received 0A 1B). Repeat.";
  const shown = incidents([error(5.1, "damaged"), gap(5, 5.2, reason)]);
  expect(shown).toMatchObject([{ time: 5, count: 1, errors: [] }]);
  expect(shown[0]!.gap!.reason?.en).toBe(reason);
});

it("shows each error of a gap that its reason does not tell, and what it lacks", () => {
  const events = [
    error(5.1, "late", "0102", null),
    error(5.2, "damaged"),
    error(5.3, "damaged", "0102", "FF"),
    gap(5, null, "damaged (sent 01 02, received 0A 1B)"),
  ];
  const [only, ...more] = incidents(events);
  expect(more).toEqual([]);
  expect(only!.count).toBe(3);
  expect(only!.errors.map(({ error: { time }, text, bytes }) => [time, text, bytes])).toEqual([
    [5.1, true, false],
    [5.3, false, true],
  ]);
});

it("loses and repeats no error, and shows those without a gap by themselves, newest first", () => {
  const events: LineEvent[] = [];
  for (let at = 0; at < 30; at += 1) {
    events.push(error(at + 0.5, `e${at}`));
    if (at % 3 === 0) events.push(gap(at + 0.4, at + 0.6, `e${at} (sent 01 02, received 0A 1B)`));
  }
  const shown = incidents(events);
  expect(shown.length).toBe(30);
  expect(shown.reduce((sum, { count }) => sum + count, 0)).toBe(30);
  expect(shown.filter(({ gap }) => gap).every(({ errors }) => errors.length === 0)).toBe(true);
  expect(shown.map(({ time }) => time)).toEqual(shown.map(({ time }) => time).sort((a, b) => b - a));
});

it("keeps the latest, and nothing but errors, gaps, moved adapters and dates", () => {
  const markers: LineEvent[] = [{ kind: "marker", time: 1, label: "" }];
  const many = Array.from({ length: 300 }, (_, at) => error(at, "e"));
  const text = { en: "slept", ru: "спал" };
  const clock: LineEvent = { kind: "clock", time: 401, seconds: 60, slept: true, before: 341, after: 401, text };
  const shown = incidents([...markers, ...many, { kind: "adapter", time: 400, port: "b", before: "a" } as LineEvent, clock]);
  expect(shown.length).toBe(100);
  expect(shown.slice(0, 2).map(({ moved }) => moved!.kind)).toEqual(["clock", "adapter"]);
  expect(shown.at(-1)!.time).toBe(202);
});
