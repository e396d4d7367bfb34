import { beforeEach, expect, it, vi } from "vitest";
import type { LineEvent, State } from "../api/types";
import { served } from "../platform/host";
import { Stores } from "../../stores";
import { lostBetween } from "./whileAway";

const gap = (began: number, ended: number | null): LineEvent => ({ kind: "gap", time: ended ?? began, began, ended, reason: null });
const state = (file: string | null): State => ({ line: "sampling", recording: file === null ? null : { file } }) as State;

it("what was lost is the time of the gaps, once, as far as they are in it", () => {
  expect(lostBetween([], 10, 20)).toBe(0);
  expect(lostBetween([gap(12, 15), gap(13, 14), gap(1, 2), gap(30, 31)], 10, 20)).toBe(3);
  expect(lostBetween([gap(18, null), gap(5, 11)], 10, 20)).toBe(3);
});

let stores: Stores;
let now: number;

beforeEach(() => {
  stores = new Stores(served);
  now = 100;
  vi.spyOn(stores.live, "now").mockImplementation(() => now);
  stores.live.link = "open";
  stores.live.state = state("a.pcapng");
});

const said = () => stores.toasts.shown.map(({ text }) => text());

function away(seconds: number, events: LineEvent[], after: State) {
  stores.whileAway.hide();
  now += seconds;
  stores.live.events = events;
  stores.live.state = after;
  stores.whileAway.back();
}

it("a call that cost values is said, with the recording that goes on", () => {
  away(60, [gap(110, 150)], state("a.pcapng"));
  expect(said()).toEqual(["While the page was in the background no values came for 40 s. The recording goes on, with a gap."]);
});

it("a recording that has ended meanwhile is named", () => {
  away(300, [gap(101, 300)], state(null));
  expect(said()).toEqual(["While the page was in the background no values came for 03:19. The recording has ended: a.pcapng."]);
});

it("nothing is said of what lost nothing, or was not there", () => {
  away(60, [gap(110, 111)], state("a.pcapng"));
  stores.live.state = { ...state(null), line: "echo-only" };
  away(60, [gap(180, 200)], state(null));
  stores.live.state = state(null);
  stores.whileAway.hide();
  stores.live.link = "lost";
  stores.whileAway.back();
  expect(said()).toEqual([]);
});

it("a date that the program was set to meanwhile is no loss", () => {
  stores.whileAway.hide();
  now += 1030;
  stores.live.later = 1000;
  stores.live.events = [gap(1090, 1095)]; // before
  stores.whileAway.back();
  expect(said()).toEqual([]);
});
