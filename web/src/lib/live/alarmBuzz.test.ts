import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { State } from "../api/types";
import { served } from "../platform/host";
import { saveSetting } from "../platform/storage";
import { Stores } from "../../stores";

const alarm = (name: string, level: "warning" | "danger") => ({ name, level }) as State["alarms"][number];
const vibrate = vi.fn();

beforeEach(() => {
  vibrate.mockReset();
  vi.stubGlobal("navigator", { vibrate });
});
afterEach(() => {
  saveSetting("alarm-sound", "");
  vi.unstubAllGlobals();
});

function felt(...states: (State["alarms"] | null)[]) {
  const { alarmBuzz } = new Stores(served);
  for (const alarms of states) alarmBuzz.look(alarms);
  return vibrate.mock.calls.map(([pattern]) => (pattern as number[]).length);
}

const [hot, hotter, low] = [alarm("TWAT", "warning"), alarm("TWAT", "danger"), alarm("UACC", "warning")];

it("once when a channel goes beyond a limit, longer for a danger", () => {
  expect(felt([], [hot], [hot], [hot, low], [hotter, low], [hotter, low])).toEqual([1, 1, 5]);
});

it("again after it was within its limits; not when a danger becomes a warning", () => {
  expect(felt([], [hotter], [hot], [], [hot])).toEqual([5, 1]);
});

it("not for what was there when the page was opened, or when the program came back", () => {
  expect(felt([hot], [hot], null, [hot, low])).toEqual([]);
});

it("not for a person who has switched the sound off", () => {
  saveSetting("alarm-sound", "off");
  expect(felt([], [hot])).toEqual([]);
  saveSetting("alarm-sound", "on");
  expect(felt([], [hot])).toEqual([1]);
});

it("not before the first touch, when a browser refuses", () => {
  vi.stubGlobal("navigator", { vibrate, userActivation: { hasBeenActive: false } });
  expect(felt([], [hot])).toEqual([]);
  vi.stubGlobal("navigator", {});
  expect(felt([], [hot])).toEqual([]);
});
