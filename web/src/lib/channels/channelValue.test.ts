import { describe, expect, it } from "vitest";
import { sideOf } from "./channelValue.svelte";

const channel = { reference: [800, 900] as [number, number] };
const warm = { idle: 1, coolant: 85 };

describe("the side of the reference", () => {
  it("is said of an engine that idles warm", () => {
    expect([799, 800, 900, 901].map((value) => sideOf(value, channel, warm))).toEqual(["low", null, null, "high"]);
  });

  it("is not said of any other engine, nor without values or a reference", () => {
    expect(sideOf(2000, channel, { idle: 0, coolant: 85 })).toBeNull();
    expect(sideOf(1200, channel, { idle: 1, coolant: 20 })).toBeNull();
    expect(sideOf(1200, channel, { idle: undefined, coolant: undefined })).toBeNull();
    expect(sideOf(undefined, channel, warm)).toBeNull();
    expect(sideOf(1200, { reference: null }, warm)).toBeNull();
  });
});
