// The way from a freeze frame of a recording to its moment in the time chart.
import type { FreezeFrame } from "../../lib/api/types";
import { moments } from "../../lib/display/moments.svelte";
import { route } from "../../lib/frame/router.svelte";
import { player } from "../../lib/recording/player.svelte";
import { view } from "../chart/time/view.svelte";

/** s before and after the moment. */
const AROUND = 10;

export function showMoment({ without, seen }: FreezeFrame, title: () => string): void {
  player.pause();
  player.seek(seen);
  moments.mark(title, [{ from: without, to: seen }]);
  view.show(without - AROUND, seen + AROUND);
  route.go("chart");
}
