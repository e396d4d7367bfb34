import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { backCloses } from "./backCloses";

class Navigation extends EventTarget {
  currentEntry = { index: 3 };
}

let navigation: Navigation;
let windowEvents: EventTarget;
let dialogs: { close: () => void }[];
let end: () => void;

beforeEach(() => {
  vi.stubGlobal("navigation", (navigation = new Navigation()));
  windowEvents = new EventTarget();
  vi.stubGlobal("addEventListener", windowEvents.addEventListener.bind(windowEvents));
  vi.stubGlobal("removeEventListener", windowEvents.removeEventListener.bind(windowEvents));
  dialogs = [];
  vi.stubGlobal("document", { querySelectorAll: () => dialogs });
  end = backCloses();
});
afterEach(() => {
  end();
  vi.unstubAllGlobals();
});

const dialog = () => {
  const it = { close: vi.fn(() => void (dialogs = dialogs.filter((each) => each !== it))) };
  dialogs.push(it);
  return it;
};
/** The browser wants to go there; returns whether it goes. */
const goes = (index: number, navigationType = "traverse", cancelable = true) =>
  navigation.dispatchEvent(Object.assign(new Event("navigate", { cancelable }), { navigationType, destination: { index } }));
const arrives = (state: object | null) => windowEvents.dispatchEvent(Object.assign(new Event("popstate"), { state }));

it("Back closes the dialog on top, one at a time, and then leaves the screen", () => {
  const [below, top] = [dialog(), dialog()];
  expect(goes(2)).toBe(false);
  expect([top.close.mock.calls.length, below.close.mock.calls.length]).toEqual([1, 0]);
  expect(goes(2)).toBe(false);
  expect(goes(2)).toBe(true);
});

it("a link in a dialog, and Forward, are followed", () => {
  dialog();
  expect(goes(-1, "push")).toBe(true);
  expect(goes(4)).toBe(true);
  expect(dialogs).toHaveLength(1);
});

it("a browser that goes back all the same leaves no dialog over another screen", () => {
  dialog();
  expect(goes(2, "traverse", false)).toBe(true);
  arrives(null); // a new address
  expect(dialogs).toHaveLength(1);
  arrives({ entry: 2 });
  expect(dialogs).toHaveLength(0);
});
