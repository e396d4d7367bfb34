// The view of the chart: panes with their traces (stored in this browser), time window, value zoom, stacking. It outlives the screen.
import { loadSetting, saveSetting } from "../../../lib/platform/storage";
import { isForeign } from "../../../lib/recording/foreign";
import { around, SHORTEST, within, zoomed, type Window } from "./window";
import type { Stores } from "../../../stores";

export interface Trace {
  name: string;
  /** Number of the colour token, 1–8. */
  colour: number;
  hidden: boolean;
}

export interface Pane {
  id: number;
  traces: Trace[];
}

export const MOST_PANES = 5;
export const SPANS = [10, 30, 60, 300, 900, 3600];

const FIRST: string[][] = [["FREQ", "THR"], ["INJ", "JAIR"], ["UOZ"], ["TWAT", "UACC"]];

function coloured(lists: string[][]): Pane[] {
  let colour = 0;
  return lists
    .slice(0, MOST_PANES)
    .map((names, id) => ({ id, traces: names.map((name) => ({ name, colour: (colour++ % 8) + 1, hidden: false })) }));
}

/** The panes in a stored text, each channel once; the defaults if it holds none. */
export function readPanes(text: string | null): Pane[] {
  const known = new Set<string>();
  const sound = ({ name, colour }: Trace) =>
    typeof name === "string" && Number.isInteger(colour) && colour >= 1 && colour <= 8 && !known.has(name) && known.add(name);
  try {
    // eslint-disable-next-line @typescript-eslint/consistent-type-assertions -- each trace is checked by `sound`; what is no list at all is caught
    const panes = (JSON.parse(text ?? "") as Pane[]).map(({ traces }) =>
      traces.filter(sound).map(({ name, colour, hidden }) => ({ name, colour, hidden: hidden === true })),
    );
    const full = panes.filter((traces) => traces.length > 0).slice(0, MOST_PANES);
    if (full.length > 0) return full.map((traces, id) => ({ id, traces }));
  } catch {
    // Nothing stored, or not valid.
  }
  return coloured(FIRST);
}

/** How a value range was moved: centre and extent as shares of the fitted range. */
export interface Stretch {
  shift: number;
  scale: number;
}

export class View {
  /** All panes, with traces of channels that the unit shown does not have. */
  private all = $state.raw<Pane[]>(readPanes(loadSetting("chart")));
  readonly panes = $derived(this.present(this.all));
  /** Seconds in the window. */
  span = $state(60);
  /** The right edge; null: follows. */
  end = $state<number | null>(null);
  stacked = $state(false);
  stretches = $state.raw<Record<number, Stretch>>({});
  /** Live data: everything that the page holds, growing. */
  private growing = $state(false);
  private of: string | null = null;

  readonly names = $derived([...new Set(this.panes.flatMap(({ traces }) => traces.map(({ name }) => name)))]);

  constructor(private readonly app: Pick<Stores, "absent" | "comparison" | "cursors" | "moments" | "display">) {}

  /** Other panes. Traces that are left out stay where they were. */
  change(panes: Pane[]): void {
    const left = this.all.map((pane) => ({ ...pane, traces: pane.traces.filter(({ name }) => this.app.absent.hides(name)) }));
    const kept = panes.map((pane) => ({ ...pane, traces: [...pane.traces, ...(left.find(({ id }) => id === pane.id)?.traces ?? [])] }));
    const gone = left.filter(({ id }) => !panes.some((pane) => pane.id === id));
    this.all = tidy([...kept, ...gone]);
    saveSetting("chart", JSON.stringify(ownOnly(this.all)));
  }

  private present(panes: Pane[]): Pane[] {
    return panes.map((pane) => ({ ...pane, traces: this.app.absent.without(pane.traces) })).filter(({ traces }) => traces.length > 0);
  }

  /** The window now, as [from, to]. */
  window(): [number, number] {
    const end = this.end ?? this.app.display.source.now();
    return [end - this.span, end];
  }

  follow(): void {
    this.end = null;
  }

  show(from: number, to: number): void {
    this.set(within(to, to - from, this.bounds()));
  }

  private set({ from, to }: Window): void {
    this.span = to - from;
    this.end = to;
    this.growing = false;
  }

  /** The times that a window may contain: of a recording, with some room, and of the one beside it. Null: live data, no limits. */
  private bounds(): Window | null {
    const { columns, kind } = this.app.display.source;
    if (kind === "live" || columns.length < 2) return null;
    let { first, last } = columns;
    if (this.app.comparison.active && this.app.comparison.columns.length > 1) {
      first = Math.min(first, this.app.comparison.columns.first + this.app.comparison.lag);
      last = Math.max(last, this.app.comparison.columns.last + this.app.comparison.lag);
    }
    const room = (last - first) * 0.01;
    return { from: first - room, to: last + room };
  }

  /** Seconds that there are to show; infinite for live data. */
  get longest(): number {
    const bounds = this.bounds();
    return bounds ? bounds.to - bounds.from : Infinity;
  }

  /** Whether everything is shown. */
  get whole(): boolean {
    return this.app.display.source.kind === "live" ? this.growing && this.end === null : this.span >= this.longest * 0.999;
  }

  /** New live data came: extend the window that shows everything. */
  grow(): void {
    if (this.growing && this.end === null)
      this.span = Math.max(SHORTEST, this.app.display.source.now() - this.app.display.source.columns.first);
  }

  /** Reset the window if another source is shown. */
  begin(of: string): void {
    if (of === this.of) return;
    const first = this.of === null;
    this.of = of;
    this.app.cursors.a = this.app.cursors.b = null;
    this.app.moments.clear();
    this.fit();
    if (of !== "live") this.showAll();
    else if (!first) {
      this.span = 60;
      this.growing = false;
      this.follow();
    }
  }

  /** The whole recording. */
  showAll(): void {
    const { columns } = this.app.display.source;
    if (columns.length < 2) return;
    const bounds = this.bounds();
    if (bounds) return this.set(bounds);
    this.follow();
    this.growing = true;
    this.grow();
  }

  /** Move the window so that it contains this time, centred if it was outside. */
  bring(time: number): void {
    const [from, to] = this.window();
    if (time < from || time > to) this.set(within(time + this.span / 2, this.span, this.bounds()));
  }

  /** Bring a moment into the window, and hold the window where it is. */
  bringMoment({ from, to }: { from: number; to: number }): void {
    const [begin, end] = this.window();
    if (from >= begin && to <= end) {
      this.end = end;
      return;
    }
    const span = Math.max(this.span, 1.5 * (to - from));
    this.show((from + to - span) / 2, (from + to + span) / 2);
  }

  /** Zoom around a time that keeps its place; while following, around the right edge. */
  zoom(factor: number, around: number): void {
    const [from, to] = this.window();
    this.put(zoomed({ from, to }, this.span * factor, this.end === null ? to : around, this.bounds()));
  }

  /** Show that many seconds. In a recording the player's position and the cursor stay in view, in live data the cursor or the end. */
  choose(seconds: number): void {
    const [from, to] = this.window();
    const cursor = this.app.cursors.a !== null && this.app.cursors.a >= from && this.app.cursors.a <= to ? this.app.cursors.a : null;
    const anchor = this.app.display.source.kind === "recording" ? this.app.display.source.now() : (cursor ?? to);
    this.put(around({ from, to }, seconds, this.end === null ? to : anchor, cursor, this.bounds()));
  }

  pan(seconds: number): void {
    const { source } = this.app.display;
    const end = (this.end ?? source.now()) + seconds;
    if (source.kind === "live" && !source.paused && end >= source.now()) this.end = null;
    else this.set(within(source.kind === "live" ? Math.max(end, source.columns.first) : end, this.span, this.bounds()));
  }

  /** Another window; following goes on. */
  private put(next: Window): void {
    const follows = this.end === null;
    this.set(next);
    if (follows) this.end = null;
  }

  stretch(pane: number, change: (before: Stretch) => Stretch): void {
    const before = this.stretches[pane] ?? { shift: 0, scale: 1 };
    this.stretches = { ...this.stretches, [pane]: change(before) };
  }

  /** Fit all values again. */
  fit(): void {
    this.stretches = {};
  }

  toggleTrace(pane: number, name: string): void {
    this.change(
      this.panes.map((one) =>
        one.id === pane
          ? { ...one, traces: one.traces.map((trace) => (trace.name === name ? { ...trace, hidden: !trace.hidden } : trace)) }
          : one,
      ),
    );
  }

  add(name: string, to: number): void {
    if (this.names.includes(name)) return;
    const used = this.panes.flatMap(({ traces }) => traces.map(({ colour }) => colour));
    const counts = Array.from({ length: 8 }, (_, index) => used.filter((colour) => colour === index + 1).length);
    const colour = counts.indexOf(Math.min(...counts)) + 1;
    this.place({ name, colour, hidden: false }, to, this.panes);
  }

  /** The traces of another program's log, in a pane of their own, in place of those of the one before. */
  lend(names: readonly string[]): void {
    this.change(ownOnly(this.all));
    for (const [index, name] of names.entries()) {
      const pane = this.panes.find(({ traces }) => traces.some((trace) => trace.name === names[0]));
      this.add(name, index === 0 ? -1 : (pane?.id ?? -1));
    }
  }

  move(name: string, to: number): void {
    const trace = this.panes.flatMap(({ traces }) => traces).find((one) => one.name === name);
    if (trace) this.place(trace, to, this.without(name));
  }

  remove(name: string): void {
    this.change(tidy(this.without(name)));
  }

  /** Move a trace to the pane above or below; past the last one, to a new pane. */
  shift(name: string, step: number): void {
    const at = this.panes.findIndex(({ traces }) => traces.some((trace) => trace.name === name));
    const to = at + step;
    if (at < 0 || to < 0 || to > this.panes.length || to >= MOST_PANES) return;
    if (to === this.panes.length && this.panes[at]!.traces.length === 1) return;
    this.move(name, this.panes[to]?.id ?? -1);
  }

  private without(name: string): Pane[] {
    return this.panes.map((pane) => ({ ...pane, traces: pane.traces.filter((trace) => trace.name !== name) }));
  }

  /** Add a trace to a pane, or to a new one. */
  private place(trace: Trace, to: number, panes: Pane[]): void {
    const known = panes.some(({ id }) => id === to);
    const next = known
      ? panes.map((pane) => (pane.id === to ? { ...pane, traces: [...pane.traces, trace] } : pane))
      : [...panes, { id: Math.max(-1, ...[...panes, ...this.all].map(({ id }) => id)) + 1, traces: [trace] }];
    this.change(tidy(next));
  }

  /** Set the second cursor at the first one, or remove it. */
  toggleSecond(): void {
    if (this.app.cursors.b !== null) {
      this.app.cursors.b = null;
      return;
    }
    const [from, to] = this.window();
    this.app.cursors.b = this.app.cursors.a ?? from + (to - from) / 3;
    this.app.cursors.a ??= from + ((to - from) * 2) / 3;
  }
}

/** Without the traces of another program's log, which is not there the next time. */
const ownOnly = (panes: readonly Pane[]): Pane[] =>
  tidy(panes.map((pane) => ({ ...pane, traces: pane.traces.filter(({ name }) => !isForeign(name)) })));

/** Remove empty panes and merge those beyond the maximum into the last. */
function tidy(panes: Pane[]): Pane[] {
  const full = panes.filter(({ traces }) => traces.length > 0);
  if (full.length <= MOST_PANES) return full;
  const over = full.slice(MOST_PANES).flatMap(({ traces }) => traces);
  return full.slice(0, MOST_PANES).map((pane, index) => (index === MOST_PANES - 1 ? { ...pane, traces: [...pane.traces, ...over] } : pane));
}
