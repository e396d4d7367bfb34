// The sampling plan that the page requests: the channels of the selected preset, and the chart's traces once the chart was opened after the
// preset was selected. Fewer channels are sampled faster, so selecting a preset requests its channels only. Channels with limits are always
// sampled at a low rate, so that alarms do not depend on the screen. While a recording runs no channel is removed; afterwards unused
// channels are. While another client holds control the page requests nothing, and channels that are not sampled show a dash. Free control
// is taken by a selection made here; without a selection only when no other page is connected.
import { untrack } from "svelte";
import { api } from "../api/api";
import { ApiError } from "../api/http";
import { catalog } from "../api/catalog.svelte";
import { control } from "./control.svelte";
import { live } from "../live/live.svelte";
import { attempt, toasts } from "../view/toasts.svelte";
import type { Channel, State, Wanted } from "../api/types";

/** Divisor of channels that are sampled for their alarms only: every 11th cycle. No screen offers 11, so the number also marks them. */
const ALARM_DIVISOR = 11;

class Subscriptions {
  private preset = $state.raw<readonly string[]>([]);
  private chart = $state.raw<readonly string[]>([]);

  /** A preset is on the screen; `chosen`: a person has just selected it. */
  setPreset(names: readonly string[], chosen: boolean): void {
    this.preset = names;
    if (chosen) this.chart = [];
    void this.update(chosen);
  }

  setChart(names: readonly string[], chosen: boolean): void {
    this.chart = names;
    void this.update(chosen);
  }

  /** For the frame's effect: update the plan when the connection, control or the recording changed. */
  watch(): void {
    const ready = live.link === "open" && control.allowed && catalog.loaded !== null && live.state?.line !== "off";
    void (live.state?.recording != null);
    if (ready) untrack(() => void this.update(false));
  }

  get names(): string[] {
    return [...new Set([...this.preset, ...this.chart])].filter((name) => catalog.get(name));
  }

  /** Add every channel to the plan. Returns false when the request failed; a toast has shown why. */
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
      // Another client has taken control meanwhile; its plan applies.
      if (error.code !== "NotController") toasts.error(() => error.advice, { code: error.code });
    }
  }
}

export const subscriptions = new Subscriptions();

/** All channels except those that the ECU does not support. */
export function supportedNames(channels: readonly { name: string }[], state: Pick<State, "dropped_parameters">): string[] {
  return channels.map(({ name }) => name).filter((name) => !state.dropped_parameters.includes(name));
}

/** Channels that can raise an alarm. */
export function alarmChannels(channels: readonly Pick<Channel, "name" | "limits" | "alarm_when_true">[]): string[] {
  return channels.filter(({ limits, alarm_when_true }) => limits !== null || alarm_when_true !== "none").map(({ name }) => name);
}

/** The shown channels, and the alarm channels at their low rate. */
export function withAlarmChannels(shown: readonly Wanted[], alarmChannels: readonly string[]): Wanted[] {
  const names = new Set(shown.map(({ name }) => name));
  return [...shown, ...alarmChannels.filter((name) => !names.has(name)).map((name) => ({ name, every: ALARM_DIVISOR }))];
}

/** The plan to request; null if the current one already does. Divisors stay as they are, except those set for alarms only. */
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
