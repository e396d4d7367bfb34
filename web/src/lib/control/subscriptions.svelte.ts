// The channels that come first. The program samples every channel, so another preset or other traces leave no hole, neither in the chart nor
// in a recording. Where each channel costs time (requests one after the other), those of the selected preset come first, and the chart's
// traces once the chart was opened after the preset was selected; the others are read in every fifth cycle. A script may have reduced the
// plan: then channels that are shown here are added to it. While another client holds control the page requests nothing. Free control is
// taken by a selection made here; without a selection only when no other page is connected.
import { ApiError } from "../api/http";
import type { State, Wanted } from "../api/types";
import { isForeign } from "../recording/foreign";
import type { Stores } from "../../stores";
import { watch } from "../platform/watch.svelte";

export class Subscriptions {
  private preset = $state.raw<readonly string[]>([]);
  private chart = $state.raw<readonly string[]>([]);
  /** A person's selection waits for the connection or for the catalog: it still may take free control beside other pages. */
  private waiting = false;

  constructor(private readonly app: Pick<Stores, "api" | "catalog" | "control" | "live" | "toasts">) {}

  /** These are on the screen; `chosen`: a person has just selected them. */
  set(where: "preset" | "chart", names: readonly string[], chosen: boolean): void {
    if (where === "preset" && chosen) this.chart = [];
    this[where] = names;
    void this.update(chosen);
  }

  /** For a component while it is initialised: what it shows, and whether a person has just selected that. */
  shows(where: "preset" | "chart", names: () => readonly string[] | null, chosen: () => boolean): void {
    watch(names, (shown) => {
      if (shown?.length) this.set(where, shown, chosen());
    });
  }

  /** Update the request when the connection or control has changed. */
  refresh(): void {
    const { catalog, control, live } = this.app;
    if (live.link === "open" && control.allowed && catalog.loaded !== null && live.state?.line !== "off") void this.update(false);
  }

  get names(): string[] {
    return [...new Set([...this.preset, ...this.chart])].filter((name) => {
      const channel = this.app.catalog.get(name);
      return channel && !channel.instrument && !isForeign(name);
    });
  }

  /** Add every channel to the plan. Returns false when the request failed; a toast has shown why. */
  subscribeAll(): Promise<boolean> {
    return this.add(this.app.catalog.ofUnit.map(({ name }) => name));
  }

  /** Add channels to a plan without them. Returns false when the request failed; a toast has shown why. */
  async add(names: readonly string[]): Promise<boolean> {
    const state = this.app.live.state;
    const wanted = state && planWith(names, state);
    return !wanted || (await this.app.toasts.attempt(() => this.app.api.plan(wanted, state.plan.method, state.plan.rate))) !== undefined;
  }

  private async update(chosen: boolean): Promise<void> {
    const state = this.app.live.state;
    const open = this.app.live.link === "open" && state !== null;
    this.waiting = (this.waiting || chosen) && (!open || this.app.control.allowed);
    if (!open || !this.app.control.allowed || this.names.length === 0) return;
    // A channel was added or deleted just now: the page's catalog or its state is not the present one yet.
    if (this.app.catalog.loaded?.version !== state.catalog) return;
    if (!this.waiting && !this.app.control.mine && (state.viewers > 1 || state.line === "off")) return;
    this.waiting = false;
    const { names } = this;
    const wanted = planWith(names, state);
    try {
      if (wanted) await this.app.api.plan(wanted, state.plan.method, state.plan.rate);
      if (!isSame(names, state.plan.first)) await this.app.api.first(names);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      // Another client has taken control meanwhile; its request applies.
      if (error.code !== "NotController") this.app.toasts.error(() => error.advice, { code: error.code });
    }
  }
}

/** All channels except those that the ECU does not support. */
export function supportedNames(channels: readonly { name: string }[], state: Pick<State, "dropped_parameters">): string[] {
  return channels.map(({ name }) => name).filter((name) => !state.dropped_parameters.includes(name));
}

/** The plan with `names` added; null: it has them. Divisors stay as they are. */
export function planWith(names: readonly string[], state: Pick<State, "plan">): Wanted[] | null {
  const before = new Set(state.plan.wanted.map(({ name }) => name));
  const missing = names.filter((name) => !before.has(name));
  if (missing.length === 0) return null;
  return [...state.plan.wanted.map(({ name, every }) => ({ name, every })), ...missing.map((name) => ({ name, every: 1 }))];
}

/** Whether both have the same names, in any order. */
export function isSame(names: readonly string[], others: readonly string[]): boolean {
  return names.length === others.length && names.every((name) => others.includes(name));
}
