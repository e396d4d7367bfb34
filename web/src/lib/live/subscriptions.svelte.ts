// What the line is asked for: what the chosen preset shows, and the chart's traces once the chart was opened after it was chosen. Fewer
// channels come faster, so choosing a preset asks for its own and no more; but what has limits is asked in passing whatever is shown, since
// an alarm must not end by looking elsewhere. While recording nothing is taken away: a recording keeps at
// least what it had; when it ends, what nobody looks at goes. Somebody else at the controls: nothing is asked, and what is not sampled shows a
// dash. A free seat is taken by a choice made here, not by looking on: only a page that is alone takes it by itself.
import { untrack } from "svelte";
import { api } from "../api/api";
import { ApiError } from "../api/http";
import { catalog } from "../api/catalog.svelte";
import { control } from "./control.svelte";
import { live } from "./live.svelte";
import { attempt, toasts } from "../view/toasts.svelte";
import type { Channel, State, Wanted } from "../api/types";

/** In every how manieth set that comes which is only alarmChannels. A number that nobody chooses: by it a page knows what was asked in passing. */
const ALARM_DIVISOR = 11;

class Subscriptions {
  private preset = $state.raw<readonly string[]>([]);
  private chart = $state.raw<readonly string[]>([]);

  /** A preset is on the screen. */
  setPreset(names: readonly string[], chosen: boolean): void {
    this.preset = names;
    if (chosen) this.chart = [];
    void this.update(chosen);
  }

  setChart(names: readonly string[], chosen: boolean): void {
    this.chart = names;
    void this.update(chosen);
  }

  /** For the frame: asks again when the line, the controls or a recording changed. */
  watch(): void {
    const ready = live.link === "open" && control.allowed && catalog.loaded !== null && live.state?.line !== "off";
    void (live.state?.recording != null);
    if (ready) untrack(() => void this.update(false));
  }

  get names(): string[] {
    return [...new Set([...this.preset, ...this.chart])].filter((name) => catalog.get(name));
  }

  /** Everything there is to ask, besides what is asked: while recording it stays so. False: it failed, and was said. */
  async subscribeAll(): Promise<boolean> {
    const state = live.state;
    if (!state) return false;
    const wanted = planFor(supportedNames(catalog.channels, state), [], state);
    return wanted === null || (await attempt(() => api.plan(wanted, state.plan.method, state.plan.rate))) !== undefined;
  }

  private async update(chosen: boolean): Promise<void> {
    const state = live.state;
    if (!state || live.link !== "open" || !control.allowed || this.names.length === 0) return;
    if (!chosen && !control.mine && (state.viewers > 1 || state.line === "off")) return;
    const wanted = planFor(this.names, alarmChannels(catalog.channels), state);
    if (!wanted) return;
    try {
      await api.plan(wanted, state.plan.method, state.plan.rate);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      // Somebody took the controls in between: they decide.
      if (error.code !== "NotController") toasts.error(() => error.advice, { code: error.code });
    }
  }
}

export const subscriptions = new Subscriptions();

/** All channels but those that the unit refuses. */
export function supportedNames(channels: readonly { name: string }[], state: Pick<State, "dropped_parameters">): string[] {
  return channels.map(({ name }) => name).filter((name) => !state.dropped_parameters.includes(name));
}

/** What can be an alarm. */
export function alarmChannels(channels: readonly Pick<Channel, "name" | "limits" | "alarm_when_true">[]): string[] {
  return channels.filter(({ limits, alarm_when_true }) => limits !== null || alarm_when_true !== "none").map(({ name }) => name);
}

/** What is shown, and in passing what is only alarmChannels. */
export function withAlarmChannels(shown: readonly Wanted[], alarmChannels: readonly string[]): Wanted[] {
  const names = new Set(shown.map(({ name }) => name));
  return [...shown, ...alarmChannels.filter((name) => !names.has(name)).map((name) => ({ name, every: ALARM_DIVISOR }))];
}

/** The plan to ask for; null: the one in force does. How often each is asked stays as it was, unless that was in passing. */
export function planFor(names: readonly string[], alarmChannels: readonly string[], state: Pick<State, "plan" | "recording">): Wanted[] | null {
  const before = new Map(state.plan.wanted.map(({ name, every }) => [name, every]));
  const after = new Map<string, number>();
  for (const name of names) after.set(name, divisorOf(before.get(name)));
  if (state.recording) for (const [name, every] of before) if (!after.has(name)) after.set(name, every);
  const wanted = withAlarmChannels([...after].map(([name, every]) => ({ name, every })), alarmChannels);
  const same = wanted.length === before.size && wanted.every(({ name, every }) => before.get(name) === every);
  return same ? null : wanted;
}

const divisorOf = (every: number | undefined): number => (every === undefined || every === ALARM_DIVISOR ? 1 : every);
