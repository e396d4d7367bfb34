import { expect, it } from "vitest";
import { channelOf } from "../../../test/pageRig";
import { searched } from "./channelSearch";

const CHANNELS = [
  channelOf("FREQX", { names: ["обороты хх"] }),
  channelOf("FREQ", { names: ["rpm", "обороты", "оборот"], text: { en: "Crankshaft speed", ru: "Частота вращения коленвала" } }),
  channelOf("UACC", { names: ["batt_v"] }),
];
const found = (typed: string) => searched(CHANNELS, typed).map(({ name }) => name);

it("finds a channel by any of its names, a whole one first", () => {
  expect(found("rpm")).toEqual(["FREQ"]);
  expect(found("Обороты")).toEqual(["FREQ", "FREQX"]);
  expect(found("оборот")).toEqual(["FREQ", "FREQX"]);
  expect(found("Batt V")).toEqual(["UACC"]);
  expect(found("коленвал")).toEqual(["FREQ"]);
  expect(found("freq")).toEqual(["FREQ", "FREQX"]);
  expect(found("  ")).toEqual(["FREQX", "FREQ", "UACC"]);
  expect(found("нет такого")).toEqual([]);
});
