// The way from a freeze frame of a recording to its moment in the time chart.
import type { FreezeFrame } from "../../lib/api/types";
import type { Stores } from "../../stores";

/** s before and after the moment. */
const AROUND = 10;

export function showMoment({ moments, player, route, view }: Stores, { without, seen }: FreezeFrame, title: () => string): void {
  player.pause();
  player.seek(seen);
  moments.mark(title, [{ from: without, to: seen }]);
  view.show(without - AROUND, seen + AROUND);
  route.go("chart");
}
