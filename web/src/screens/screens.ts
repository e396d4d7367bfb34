// The screens in the order of their keys, 1 to 9. All are part of one bundle, so that they work when the program has ended.
import type { Component } from "svelte";
import type { IconName } from "../components/basic/icons";
import Chart from "./chart/Screen.svelte";
import Connection from "./connection/Screen.svelte";
import Faults from "./faults/Screen.svelte";
import Live from "./live/Screen.svelte";
import Memory from "./memory/Screen.svelte";
import Passport from "./passport/Screen.svelte";
import Recordings from "./recordings/Screen.svelte";
import Report from "./report/Screen.svelte";
import Tests from "./tests/Screen.svelte";
import type { ScreenName } from "../lib/frame/router.svelte";

export interface ScreenEntry {
  name: ScreenName;
  icon: IconName;
  component: Component;
  /** In the bar of a phone, which has room for five; the others are behind *More*. */
  inBar?: true;
}

export const screens: readonly ScreenEntry[] = [
  { name: "live", icon: "live", component: Live, inBar: true },
  { name: "chart", icon: "chart", component: Chart, inBar: true },
  { name: "faults", icon: "faults", component: Faults, inBar: true },
  { name: "tests", icon: "tests", component: Tests, inBar: true },
  { name: "passport", icon: "passport", component: Passport },
  { name: "memory", icon: "memory", component: Memory },
  { name: "recordings", icon: "recordings", component: Recordings, inBar: true },
  { name: "report", icon: "report", component: Report },
  { name: "connection", icon: "connection", component: Connection },
];
