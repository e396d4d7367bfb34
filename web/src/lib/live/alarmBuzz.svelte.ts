// Alarms as vibration, for a phone in a holder or a pocket: once when a channel goes beyond a limit, longer for a danger, and again only if that
// channel was within its limits meanwhile or the warning becomes a danger. Whoever has switched the alarm sound off wants no vibration either. Alarms
// that were there when the page was opened do not begin.
import { watch } from "../platform/watch.svelte";
import type { Level, State } from "../api/types";
import type { Stores } from "../../stores";

/** ms of vibration and rest, in turn. */
const PATTERNS: Record<Level, number[]> = { warning: [250], danger: [400, 150, 400, 150, 400] };

export class AlarmBuzz {
  private before: ReadonlyMap<string, Level> | null = null;

  constructor(private readonly app: Pick<Stores, "alarmSound" | "live">) {}

  /** For the frame while it is initialised. */
  follow(): void {
    const { live } = this.app;
    watch(
      () => (live.link === "open" && live.state ? live.state.alarms : null),
      (alarms) => this.look(alarms),
    );
  }

  look(alarms: State["alarms"] | null): void {
    if (alarms === null) return void (this.before = null);
    const { before } = this;
    const now = (this.before = new Map(alarms.map(({ name, level }) => [name, level])));
    if (before === null || this.app.alarmSound.silenced) return;
    const begun = [...now].filter(([name, level]) => before.get(name) !== level && before.get(name) !== "danger").map(([, level]) => level);
    if (begun.length > 0) vibrate(PATTERNS[begun.includes("danger") ? "danger" : "warning"]);
  }
}

/** Before the first touch a browser refuses, with a complaint in its log. */
function vibrate(pattern: number[]): void {
  if (navigator.userActivation?.hasBeenActive === false) return;
  navigator.vibrate?.(pattern);
}
