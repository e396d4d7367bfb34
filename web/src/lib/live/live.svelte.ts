// The live line: one WebSocket to the program, its state, the latest value of everything, the last hour as columns, what happened.
// Comes back by itself, after ½ s, 1, 2, … at most 8 s; and at once when the page becomes visible again or the network returns.
import { api } from "../api/api";
import { address } from "../api/http";
import { frameClock } from "../view/frameClock.svelte";
import { clientId, clientName, controlLease } from "../api/client";
import { Columns } from "../series/columns";
import { EventLog } from "./eventLog";
import type { LineEvent, LiveMessage, Rows, State } from "../api/types";

/** What is kept of the past: seconds, rows. */
const KEPT_SECONDS = 3600;
const FIRST_HISTORY = 900;
const FULL_DETAIL = 60;
const DELAYS = [500, 1000, 2000, 4000, 8000];

export interface Latest {
  value: number;
  time: number;
}

class LiveLine {
  /** `lost`: the program does not answer; nothing on the screen is of now. */
  link = $state<"connecting" | "open" | "lost">("connecting");
  state = $state.raw<State | null>(null);
  events = $state.raw<readonly LineEvent[]>([]);
  /** Counts messages with data: what draws from `columns` or `latest` reads it to be drawn again. */
  /** How often the past was added: what stands still is drawn again, too. */
  historyLoads = $state(0);
  tick = $state(0);
  /** The program's clock, as of the last message; `now()` goes on from there. */
  clock = $state(0);
  /** Messages the program dropped because this page was too slow, since it was opened. */
  dropped = $state(0);

  readonly columns = new Columns(1 << 18, KEPT_SECONDS);
  readonly latest = new Map<string, Latest>();
  /** Lowest and highest since `forget`, at first of all that was found. */
  readonly extremes = new Map<string, { min: number; max: number }>();

  private socket: WebSocket | null = null;
  private attempts = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private receivedAt = 0;
  private started = false;
  /** Rows that came while the past is being asked for. */
  private pending: Rows[] | null = null;
  private readonly eventLog = new EventLog();

  start(): void {
    if (this.started) return;
    this.started = true;
    this.open();
    document.addEventListener("visibilitychange", () => document.hidden || this.reconnectNow());
    window.addEventListener("online", () => this.reconnectNow());
  }

  /** The program's time at this moment, in its seconds. */
  now(): number {
    return this.clock + (performance.now() - this.receivedAt) / 1000;
  }

  private open(): void {
    clearTimeout(this.timer);
    const url = new URL(address("/live", { client: clientId, name: clientName() }), location.href);
    url.protocol = url.protocol.replace("http", "ws");
    const socket = new WebSocket(url);
    this.socket = socket;
    socket.onmessage = (message) => {
      if (socket !== this.socket) return;
      this.receive(JSON.parse(message.data as string) as LiveMessage);
    };
    socket.onclose = () => {
      if (socket === this.socket) this.onLost();
    };
  }

  private onLost(): void {
    this.socket = null;
    this.link = "lost";
    const wait = DELAYS[Math.min(this.attempts, DELAYS.length - 1)]!;
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
    this.receivedAt = performance.now();
    this.clock = message.now;
    if (this.link !== "open") {
      this.link = "open";
      this.attempts = 0;
      void this.loadHistory();
    }
    this.dropped += message.dropped;
    frameClock.request();
    if (message.state) {
      this.state = message.state;
      controlLease.held = message.state.controller?.you ?? false;
    }
    if (message.events?.length) this.addEvents(message.events);
    if (message.data) this.add(message.data);
  }

  private add(rows: Rows): void {
    // Another connection with a clock of its own, which began earlier: what is held is of another time.
    if ((rows.times[rows.times.length - 1] ?? Infinity) < this.columns.last - FULL_DETAIL) {
      this.columns.clear();
      this.latest.clear();
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
      this.updateExtremes(name, cells);
    });
    this.tick += 1;
  }

  /** Lowest and highest begin anew. */
  resetExtremes(): void {
    this.extremes.clear();
    frameClock.request();
  }

  private updateExtremes(name: string, cells: Rows["values"][number]): void {
    for (const cell of cells) {
      if (cell === null || cell === undefined) continue;
      const value = Number(cell);
      const held = this.extremes.get(name);
      if (!held) this.extremes.set(name, { min: value, max: value });
      else if (value < held.min) held.min = value;
      else if (value > held.max) held.max = value;
    }
  }

  private addEvents(events: LineEvent[]): void {
    this.events = this.eventLog.add(events);
  }

  /**
   * What went by before this page was opened, or while it was away, from the program's memory: the last minute in full, before that coarse.
   * What comes meanwhile waits, so that rows stay in order.
   */
  private async loadHistory(): Promise<void> {
    if (this.pending) return;
    this.pending = [];
    const away = this.columns.length > 0 ? Math.max(1, this.now() - this.columns.last) : FIRST_HISTORY;
    try {
      if (away > FULL_DETAIL) await this.loadPart(Math.min(away, KEPT_SECONDS), 4000, FULL_DETAIL);
      await this.loadPart(Math.min(away + 1, FULL_DETAIL), 20_000, 0);
    } catch {
      // The past is a comfort; without it the chart goes on here.
    }
    for (const rows of this.pending) this.columns.append(rows.names, rows.times, rows.values);
    this.pending = null;
    this.historyLoads += 1;
    this.tick += 1;
    frameClock.request();
  }

  /** All but the last `before` seconds of it. */
  private async loadPart(seconds: number, points: number, before: number): Promise<void> {
    const { events, names, times, values } = await api.history(seconds, points);
    const until = (times[times.length - 1] ?? 0) - before;
    const count = times.findLastIndex((time) => time <= until) + 1;
    const kept = values.map((cells) => cells.slice(0, count));
    this.columns.append(names, times.slice(0, count), kept);
    names.forEach((name, index) => this.updateExtremes(name, kept[index]!));
    this.events = this.eventLog.add(events);
  }
}

export const live = new LiveLine();
