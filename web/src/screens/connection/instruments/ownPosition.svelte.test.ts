import { beforeEach, expect, it, vi } from "vitest";
import type { Position } from "../../../lib/api/types";
import { OwnPosition, positionOf } from "./ownPosition.svelte";

const HERE = {
  coords: { latitude: 55.7, longitude: 37.6, altitude: null, speed: 0, heading: NaN },
  timestamp: 1,
} as unknown as GeolocationPosition;
const geolocation = { watchPosition: vi.fn<Geolocation["watchPosition"]>(() => 7), clearWatch: vi.fn<Geolocation["clearWatch"]>() };

beforeEach(() => {
  vi.clearAllMocks();
  vi.stubGlobal("isSecureContext", true);
  vi.stubGlobal("navigator", { geolocation });
});

it("a position is taken as the browser gives it, without what is not known", () => {
  expect(positionOf(HERE)).toEqual({ latitude: 55.7, longitude: 37.6, altitude: null, speed: 0, heading: null });
});

it("each position is sent until the end, but none while the one before is on its way", async () => {
  const sent: Position[] = [];
  let arrive: () => void = () => undefined;
  const own = new OwnPosition((position) => {
    sent.push(position);
    return new Promise<void>((resolve) => (arrive = resolve));
  });
  const end = own.start();
  expect(own.state).toBe("waiting");
  const [come] = geolocation.watchPosition.mock.calls[0]!;
  come(HERE);
  come(HERE);
  expect(sent).toHaveLength(1);
  arrive();
  await vi.waitFor(() => expect(own.state).toBe("sent"));
  come(HERE);
  expect(sent).toHaveLength(2);
  end();
  expect(geolocation.clearWatch).toHaveBeenCalledWith(7);
  expect(own.state).toBe("off");
});

it("a refusal is told from a position that can't be had", () => {
  const own = new OwnPosition(() => Promise.resolve());
  own.start();
  const [, fail] = geolocation.watchPosition.mock.calls[0]!;
  for (const [code, state] of [
    [1, "refused"],
    [2, "unavailable"],
    [3, "unavailable"],
  ] as const) {
    fail!({ code, PERMISSION_DENIED: 1 } as GeolocationPositionError);
    expect(own.state).toBe(state);
  }
});

it("a page that is not encrypted, and a browser without positions, say so", () => {
  vi.stubGlobal("isSecureContext", false);
  const own = new OwnPosition(() => Promise.resolve());
  own.start();
  expect([own.state, own.hindrance]).toEqual(["plain", "plain"]);
  vi.stubGlobal("isSecureContext", true);
  vi.stubGlobal("navigator", {});
  own.start();
  expect(own.state).toBe("none");
});

it("the wish outlives the page", () => {
  new OwnPosition(() => Promise.resolve()).want(true);
  expect(new OwnPosition(() => Promise.resolve()).wanted).toBe(true);
});
