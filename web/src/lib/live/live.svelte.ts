// The live connection: one WebSocket, the state, the latest value of each channel, the last hour as columns, and the events. Reconnects
// after ½ s, then after 1 s, hidden after 8 s, and at once when the page becomes visible or the network returns. A socket that brings nothing is
// lost, too: a network that has gone, or a program that was stopped, closes none.
import { address } from "../api/http";
import { frameClock } from "../platform/frameClock.svelte";
import { clientId, clientName, controlLease, pageId } from "../api/client";
import { Columns, type Extremes } from "../series/columns";
import { PulseCounter, type Pulses } from "../series/pulses";
import { EventLog, movedEvent } from "./eventLog";
import { answering } from "./lineState";
import type { LineEvent, LiveMessage, Rows, State } from "../api/types";
import type { Host, LiveSocket } from "../platform/host";
import type { ApiClient } from "../api/api";

/** Seconds: kept as columns; loaded when the page opens; loaded in full detail. */
const KEPT_SECONDS = 3600;
const FIRST_HISTORY = 900;
const FULL_DETAIL = 60;
/** ms until the socket is opened again: the first time, later, and while nobody sees the page. */
const DELAYS = { first: 500, next: 1000, hidden: 8000 };
/** ms between two looks at whether messages come. */
const LOOK = 250;

export interface Latest {
  value: number;
  time: number;
}

export class Live {
  /** `lost`: the program does not answer, nothing on the screen is current. */
  link = $state<"connecting" | "open" | "lost">("connecting");
  /** The user has ended the program from this page; until it runs again. */
  ended = $state(false);
  state = $state.raw<State | null>(null);
  /** Key of the data that are asked for while the socket is open, and then stay. */
  readonly linked = $derived<true | null>(this.link === "open" || null);
  /** Whether an ECU answers now. */
  readonly answers = $derived(this.link === "open" && this.state !== null && answering(this.state));
  /** A key that changes when another ECU is connected: data read from the previous one is no longer valid. */
  readonly unit = $derived(this.state ? JSON.stringify([this.state.port, this.state.version_code, this.state.passport]) : "");
  /** The last port that data came from since the page was opened. */
  worked = $state<string | null>(null);
  events = $state.raw<readonly LineEvent[]>([]);
  /** Counts loads of history: a frozen view redraws, too. */
  historyLoads = $state(0);
  /** Counts messages with data: effects that draw from `columns` or `latest` depend on it. */
  tick = $state(0);
  /** Messages that the program dropped because this page was too slow, since the page was opened. */
  dropped = $state(0);

  /** By how many seconds the program's date was set since it began. All times here have it in them. */
  later = $state(0);

  readonly columns = new Columns(1 << 18, KEPT_SECONDS);
  /** Rows up to this time may hold only minima and maxima, which are no readings: they can be drawn, not counted. */
  decimatedUntil = $state(-Infinity);
  readonly latest = new Map<string, Latest>();
  /** Minimum and maximum of each channel since `extremesFrom`, history included. */
  readonly extremes = new Map<string, Extremes>();
  /** The program's time of the first value in `extremes`, or of the last reset; null before both. */
  extremesFrom = $state<number | null>(null);
  /** When another unit was found, the last time: older values are another car's. */
  unitSince = $state(-Infinity);
  /** Older values stay out of `extremes`. */
  private extremesReset = -Infinity;
  /** Of flags: how often each was set since the last reset, of the last hour at most when the page was opened. */
  private readonly counters = new Map<string, PulseCounter>();

  private socket: LiveSocket | null = null;
  private attempts = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  /**
   * The program's clock at the last message, and when it came; `now()` continues from them. No state: what shows the time reads the frame
   * clock, else it would be drawn at each message, besides the frames.
   */
  private clock = 0;
  private receivedAt = 0;
  private started = false;
  /** Looks since the socket was opened, or since its last message: a page that did not run has not looked. */
  private looks = 0;
  /** Rows that arrived while the history is being loaded. */
  private pending: Rows[] | null = null;
  /** Ends the loading of the history: its answer may be lost with the connection. */
  private loading = new AbortController();
  /** Channels that were changed while the history is being loaded. */
  private changed: string[] = [];
  private readonly eventLog = new EventLog();

  /** Called when another ECU is connected. */
  onother: () => void = () => undefined;
  /** Called with the first state. */
  onfirst: (state: State) => void = () => undefined;
  /** Called with all events when some have come. */
  onevents: (events: readonly LineEvent[]) => void = () => undefined;

  constructor(
    private readonly host: Pick<Host, "connect" | "patience" | "runsHere">,
    private readonly api: ApiClient,
  ) {}

  start(): void {
    if (this.started) return;
    this.started = true;
    this.open();
    document.addEventListener("visibilitychange", () => document.hidden || this.reconnectNow());
    window.addEventListener("online", () => this.reconnectNow());
    setInterval(() => this.look(), LOOK);
  }

  /** The program's time now, in seconds. */
  now(): number {
    return this.clock + (performance.now() - this.receivedAt) / 1000;
  }

  /** UNIX seconds of a time of the program's clock. */
  wallTime(time: number): number {
    return Date.now() / 1000 - (this.now() - time);
  }

  private open(): void {
    clearTimeout(this.timer);
    const socket = this.host.connect(address("/live", { client: clientId, name: clientName(), page: pageId }));
    this.socket = socket;
    this.looks = 0;
    socket.onmessage = (message) => {
      if (socket !== this.socket) return;
      // eslint-disable-next-line @typescript-eslint/consistent-type-assertions -- the program's own message, as its models say
      this.receive(JSON.parse(String(message.data)) as LiveMessage);
    };
    socket.onclose = () => {
      if (socket === this.socket) this.onLost();
    };
  }

  /** Give up a socket that has brought nothing for too long. */
  private look(): void {
    // In this page a request is not lost while the program runs; it may take long.
    if (!this.host.runsHere) this.api.waiting.look(this.link === "lost", LOOK);
    if (this.socket === null) return;
    const { first, next } = this.host.patience;
    this.looks += 1;
    if (this.looks * LOOK < (this.link === "open" ? next : first)) return;
    const { socket } = this;
    this.onLost();
    socket.close();
  }

  private onLost(): void {
    this.socket = null;
    this.link = "lost";
    this.loading.abort();
    const wait = document.hidden ? DELAYS.hidden : this.attempts === 0 ? DELAYS.first : DELAYS.next;
    this.attempts += 1;
    this.timer = setTimeout(() => this.open(), wait);
  }

  private reconnectNow(): void {
    if (this.socket === null) {
      this.attempts = 0;
      this.open();
    }
  }

  private receive(message: LiveMessage): void {
    this.looks = 0;
    this.receivedAt = performance.now();
    this.clock = message.now;
    if (this.link !== "open") {
      this.link = "open";
      this.ended = false;
      this.attempts = 0;
      void this.loadHistory();
    }
    this.dropped += message.dropped;
    frameClock.request();
    if (message.state) {
      this.use(message.state);
      controlLease.held = message.state.controller?.you ?? false;
    }
    if (message.later !== undefined && message.later !== this.later) this.move(message.later - this.later);
    if (message.events?.length) this.addEvents(message.events);
    if (message.data) this.add(message.data);
  }

  /** Seconds for which writing is unlocked. */
  get unlockedFor(): number {
    return frameClock.slowly(() => Math.max(0, (this.state?.unlocked_until ?? 0) - this.now()));
  }

  /** Use a state that the program has returned. */
  use(state: State): void {
    const { state: before, unit } = this;
    this.state = state;
    if (!before) this.onfirst(state);
    if (before && unit !== this.unit) this.onother();
    if (state.line !== "off" && state.line !== "no-port") this.worked = state.port;
  }

  private add(rows: Rows): void {
    // Rows far before the last one: a new connection with another clock. The data held no longer fits.
    if ((rows.times[rows.times.length - 1] ?? Infinity) < this.columns.last - FULL_DETAIL) {
      this.columns.clear();
      this.decimatedUntil = -Infinity;
      this.latest.clear();
      this.extremes.clear();
      this.extremesFrom = null;
      this.extremesReset = this.unitSince = -Infinity;
      this.counters.clear();
      this.eventLog.clear();
      this.events = [];
    }
    if (this.pending) this.pending.push(rows);
    else this.columns.append(rows.names, rows.times, rows.values);
    rows.names.forEach((name, index) => {
      const cells = rows.values[index]!;
      for (let row = cells.length - 1; row >= 0; row -= 1) {
        const cell = cells[row];
        if (cell === null || cell === undefined) continue;
        this.latest.set(name, { value: Number(cell), time: rows.times[row]! });
        break;
      }
      this.updateExtremes(name, rows.times, cells);
    });
    this.tick += 1;
  }

  /** The program's date was set: move all that is held, so that no value moves against another. */
  private move(seconds: number): void {
    this.later += seconds;
    this.columns.move(seconds);
    for (const [name, { value, time }] of this.latest) this.latest.set(name, { value, time: time + seconds });
    for (const rows of this.pending ?? []) rows.times = rows.times.map((time) => time + seconds);
    this.decimatedUntil += seconds;
    if (this.extremesFrom !== null) this.extremesFrom += seconds;
    this.extremesReset += seconds;
    this.unitSince += seconds;
    this.counters.clear();
    this.events = this.eventLog.move(seconds);
    this.historyLoads += 1;
    this.tick += 1;
  }

  /** Another unit answers since then: values, minima, maxima and counts from before are another car's. */
  private endUnit(since: number): void {
    this.unitSince = since;
    for (const [name, { time }] of this.latest) if (time < since) this.latest.delete(name);
    this.extremesReset = Math.max(this.extremesReset, since);
    this.counters.clear();
    if (this.extremesFrom === null || this.extremesFrom >= since) return;
    this.extremes.clear();
    this.extremesFrom = null;
    for (const rows of this.pending ?? []) rows.names.forEach((name, index) => this.updateExtremes(name, rows.times, rows.values[index]!));
    const { columns } = this;
    const from = columns.rowFrom(since);
    const times = [...columns.times(from)];
    for (const name of columns.names)
      this.updateExtremes(
        name,
        times,
        [...columns.column(name, from)!].map((value) => (Number.isNaN(value) ? null : value)),
      );
  }

  /** Restart minimum, maximum and the counts of flags. */
  resetExtremes(): void {
    this.extremes.clear();
    this.counters.clear();
    this.extremesFrom = this.extremesReset = this.now();
    frameClock.request();
  }

  /** How often a flag was set since the last reset. */
  pulses(name: string): Pulses {
    const counter = this.counters.get(name) ?? new PulseCounter(this.extremesReset);
    this.counters.set(name, counter);
    return counter.read(this.columns, name);
  }

  /** Load the history again: these channels are computed otherwise now. If it is being loaded, after that: it may hold the values of before. */
  reload(names: readonly string[]): void {
    if (this.pending) return void this.changed.push(...names);
    for (const name of names) {
      this.latest.delete(name);
      this.extremes.delete(name);
    }
    const seconds = this.columns.length ? this.now() - this.columns.first : FIRST_HISTORY;
    this.columns.clear();
    this.counters.clear();
    void this.loadHistory(Math.max(FIRST_HISTORY, seconds));
  }

  private updateExtremes(name: string, times: readonly number[], cells: Rows["values"][number]): void {
    for (let row = 0; row < cells.length; row += 1) {
      const cell = cells[row];
      const time = times[row]!;
      if (cell === null || cell === undefined || time < this.extremesReset) continue;
      if (this.extremesFrom === null || time < this.extremesFrom) this.extremesFrom = time;
      const value = Number(cell);
      const known = this.extremes.get(name);
      if (!known) this.extremes.set(name, { min: value, max: value });
      else if (value < known.min) known.min = value;
      else if (value > known.max) known.max = value;
    }
  }

  private addEvents(events: LineEvent[]): void {
    this.events = this.eventLog.add(events);
    const since = this.events.findLast((event) => event.kind === "unit" && event.another)?.time ?? -Infinity;
    if (since > this.unitSince) this.endUnit(since);
    this.onevents(this.events);
  }

  /**
   * Load what happened before the page was opened or while it was disconnected: the last minute in full detail, before that decimated.
   * Rows that arrive meanwhile are appended afterwards, so that the order is kept.
   */
  private async loadHistory(seconds = FIRST_HISTORY): Promise<void> {
    if (this.pending) return;
    this.pending = [];
    this.loading = new AbortController();
    const away = this.columns.length > 0 ? Math.max(1, this.now() - this.columns.last) : seconds;
    try {
      if (away > FULL_DETAIL) {
        await this.loadPart(Math.min(away, KEPT_SECONDS), 4000, FULL_DETAIL);
        if (this.columns.length > 0) this.decimatedUntil = this.columns.last;
      }
      await this.loadPart(Math.min(away + 1, FULL_DETAIL), 20_000, 0);
    } catch {
      // Without its history the chart starts here.
    }
    for (const rows of this.pending) this.columns.append(rows.names, rows.times, rows.values);
    this.pending = null;
    this.historyLoads += 1;
    this.tick += 1;
    frameClock.request();
    if (this.changed.length > 0 && this.link !== "lost") this.reload(this.changed.splice(0));
  }

  /** Load `seconds` of history except the last `before` seconds. */
  private async loadPart(seconds: number, points: number, before: number): Promise<void> {
    const { events, names, times: sent, values, later } = await this.api.history(seconds, points, this.loading.signal);
    const moved = this.later - later; // 0, unless the date was set between the two answers
    const times = sent.map((time) => time + moved);
    const until = (times[times.length - 1] ?? 0) - before;
    const count = times.findLastIndex((time) => time <= until) + 1;
    const selected = values.map((cells) => cells.slice(0, count));
    this.columns.append(names, times.slice(0, count), selected);
    this.addEvents(events.map((event) => movedEvent(event, moved)));
    names.forEach((name, index) => this.updateExtremes(name, times, selected[index]!));
  }
}
