// The live line: one WebSocket to the program, its state, the latest value of everything, the last hour as columns, what happened.
// Comes back by itself, after ½ s, 1, 2, … at most 8 s; and at once when the page becomes visible again or the network returns.
import { address, api } from "../api/api";
import { beat } from "../view/frameClock.svelte";
import { client, clientName, seat } from "../api/client";
import { Columns } from "../series/columns";
import { Happened } from "./eventLog";
import type { LineEvent, LiveMessage, Rows, State } from "../api/types";

/** What is kept of the past: seconds, rows. */
const HOUR = 3600;
const QUARTER = 900;
const MINUTE = 60;
const WAITS = [500, 1000, 2000, 4000, 8000];

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
  filled = $state(0);
  tick = $state(0);
  /** The program's clock, as of the last message; `now()` goes on from there. */
  clock = $state(0);
  /** Messages the program dropped because this page was too slow, since it was opened. */
  dropped = $state(0);

  readonly columns = new Columns(1 << 18, HOUR);
  readonly latest = new Map<string, Latest>();
  /** Lowest and highest since `forget`, at first of all that was found. */
  readonly extremes = new Map<string, { min: number; max: number }>();

  private socket: WebSocket | null = null;
  private tries = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private heard = 0;
  private started = false;
  /** Rows that came while the past is being asked for. */
  private waiting: Rows[] | null = null;
  private readonly known = new Happened();

  start(): void {
    if (this.started) return;
    this.started = true;
    this.open();
    document.addEventListener("visibilitychange", () => document.hidden || this.hurry());
    window.addEventListener("online", () => this.hurry());
  }

  /** The program's time at this moment, in its seconds. */
  now(): number {
    return this.clock + (performance.now() - this.heard) / 1000;
  }

  private open(): void {
    clearTimeout(this.timer);
    const url = new URL(address("/live", { client, name: clientName() }), location.href);
    url.protocol = url.protocol.replace("http", "ws");
    const socket = new WebSocket(url);
    this.socket = socket;
    socket.onmessage = (message) => {
      if (socket !== this.socket) return;
      this.take(JSON.parse(message.data as string) as LiveMessage);
    };
    socket.onclose = () => {
      if (socket === this.socket) this.lose();
    };
  }

  private lose(): void {
    this.socket = null;
    this.link = "lost";
    const wait = WAITS[Math.min(this.tries, WAITS.length - 1)]!;
    this.tries += 1;
    this.timer = setTimeout(() => this.open(), wait);
  }

  private hurry(): void {
    if (this.socket === null) {
      this.tries = 0;
      this.open();
    }
  }

  private take(message: LiveMessage): void {
    this.heard = performance.now();
    this.clock = message.now;
    if (this.link !== "open") {
      this.link = "open";
      this.tries = 0;
      void this.fill();
    }
    this.dropped += message.dropped;
    beat.poke();
    if (message.state) {
      this.state = message.state;
      seat.held = message.state.controller?.you ?? false;
    }
    if (message.events?.length) this.happened(message.events);
    if (message.data) this.add(message.data);
  }

  private add(rows: Rows): void {
    // Another connection with a clock of its own, which began earlier: what is held is of another time.
    if ((rows.times[rows.times.length - 1] ?? Infinity) < this.columns.last - MINUTE) {
      this.columns.clear();
      this.latest.clear();
      this.known.clear();
      this.events = [];
    }
    if (this.waiting) this.waiting.push(rows);
    else this.columns.append(rows.names, rows.times, rows.values);
    rows.names.forEach((name, index) => {
      const cells = rows.values[index]!;
      for (let row = cells.length - 1; row >= 0; row -= 1) {
        const cell = cells[row];
        if (cell === null || cell === undefined) continue;
        this.latest.set(name, { value: Number(cell), time: rows.times[row]! });
        break;
      }
      this.stretch(name, cells);
    });
    this.tick += 1;
  }

  /** Lowest and highest begin anew. */
  forget(): void {
    this.extremes.clear();
    beat.poke();
  }

  private stretch(name: string, cells: Rows["values"][number]): void {
    for (const cell of cells) {
      if (cell === null || cell === undefined) continue;
      const value = Number(cell);
      const held = this.extremes.get(name);
      if (!held) this.extremes.set(name, { min: value, max: value });
      else if (value < held.min) held.min = value;
      else if (value > held.max) held.max = value;
    }
  }

  private happened(events: LineEvent[]): void {
    this.events = this.known.add(events);
  }

  /**
   * What went by before this page was opened, or while it was away, from the program's memory: the last minute in full, before that coarse.
   * What comes meanwhile waits, so that rows stay in order.
   */
  private async fill(): Promise<void> {
    if (this.waiting) return;
    this.waiting = [];
    const away = this.columns.length > 0 ? Math.max(1, this.now() - this.columns.last) : QUARTER;
    try {
      if (away > MINUTE) await this.past(Math.min(away, HOUR), 4000, MINUTE);
      await this.past(Math.min(away + 1, MINUTE), 20_000, 0);
    } catch {
      // The past is a comfort; without it the chart goes on here.
    }
    for (const rows of this.waiting) this.columns.append(rows.names, rows.times, rows.values);
    this.waiting = null;
    this.filled += 1;
    this.tick += 1;
    beat.poke();
  }

  /** All but the last `before` seconds of it. */
  private async past(seconds: number, points: number, before: number): Promise<void> {
    const { events, names, times, values } = await api.history(seconds, points);
    const until = (times[times.length - 1] ?? 0) - before;
    const count = times.findLastIndex((time) => time <= until) + 1;
    const kept = values.map((cells) => cells.slice(0, count));
    this.columns.append(names, times.slice(0, count), kept);
    names.forEach((name, index) => this.stretch(name, kept[index]!));
    this.events = this.known.add(events);
  }
}

export const live = new LiveLine();
