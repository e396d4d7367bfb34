// The screens in the order of the navigation. All are part of one bundle, so that they work when the program has ended.
import type { Component } from "svelte";
import type { IconName } from "../components/basic/icons";
import Causes from "./causes/Screen.svelte";
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
  /** A digit. */
  key: string;
  /** In the bar of a phone, which has room for five; the others are behind *More*. */
  inBar?: true;
}

export const screens: readonly ScreenEntry[] = [
  { name: "live", icon: "live", key: "1", component: Live, inBar: true },
  { name: "chart", icon: "chart", key: "2", component: Chart, inBar: true },
  { name: "faults", icon: "faults", key: "3", component: Faults, inBar: true },
  { name: "tests", icon: "tests", key: "4", component: Tests, inBar: true },
  { name: "causes", icon: "causes", key: "0", component: Causes },
  { name: "passport", icon: "passport", key: "5", component: Passport },
  { name: "memory", icon: "memory", key: "6", component: Memory },
  { name: "recordings", icon: "recordings", key: "7", component: Recordings, inBar: true },
  { name: "report", icon: "report", key: "8", component: Report },
  { name: "connection", icon: "connection", key: "9", component: Connection },
];
