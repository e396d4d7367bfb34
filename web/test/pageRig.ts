// A page over a program that a test plays: what the program answers, what it is asked, what it says on its socket.
import { cleanup, render } from "@testing-library/svelte";
import type { Component } from "svelte";
import { afterEach, beforeEach, vi } from "vitest";
import type { Channel, LiveMessage, State } from "../src/lib/api/types";
import { served, type LiveSocket } from "../src/lib/platform/host";
import PageRig from "./PageRig.svelte";
import { Stores } from "../src/stores";

export interface Asked {
  method: string;
  /** Without the folder of the API. */
  path: string;
  body: unknown;
}

/** For each beginning of a path the answer's JSON, or what makes it; a number is the status of an answer without one. */
export type Answers = Record<string, unknown>;

const words = (text: string) => ({ en: text, ru: text });

/** A channel of the catalog: a number in °C unless the test says otherwise. */
export const channelOf = (name: string, more: Partial<Channel> = {}): Channel => ({
  ...({
    derived: false,
    flag: false,
    mine: false,
    own: [],
    names: [],
    decimals: 0,
    limits: null,
    gauge: null,
    reference: null,
    lamp: null,
  } as unknown as Channel),
  ...{ name, unit: words("°C"), text: words(`Value ${name}`), short: words(name), alarm_when_true: "none" },
  ...more,
});

/** Vitest's files share a window, so each test begins and ends with an empty, wide one. */
export function eachOnItsOwnPage(): void {
  beforeEach(() => {
    vi.stubGlobal("scrollTo", () => undefined);
    (window as unknown as { happyDOM: { setViewport(size: object): void } }).happyDOM.setViewport({ width: 1366, height: 768 });
    location.hash = "";
  });
  afterEach(cleanup);
}

export function page(answers: Answers = {}) {
  const asked: Asked[] = [];
  const socket: LiveSocket = { onmessage: null, onclose: null, close: () => undefined };
  const stores = new Stores({
    ...served,
    connect: () => socket,
    patience: { first: Infinity, next: Infinity },
    fetch(address, init) {
      const path = `/${address.split("api/")[1]}`;
      const body: unknown = typeof init?.body === "string" ? JSON.parse(init.body) : undefined;
      asked.push({ method: init?.method ?? "GET", path, body });
      const begin = Object.keys(answers).find((each) => path.startsWith(each));
      const answer: unknown = begin === undefined ? {} : answers[begin];
      const json: unknown = typeof answer === "function" ? (answer as (body: unknown) => unknown)(body) : answer;
      return Promise.resolve(json instanceof Response ? json : new Response(JSON.stringify(json)));
    },
  });
  stores.live.start();
  const line: Partial<State> = {
    ...{ line: "sampling", port: "COM3", rights: "control", alarms: [], errors_minute: 0, rate: 10, bus_load: 0.5, recording: null },
    ...{
      text: words("Sampling"),
      reason: null,
      model: words("Mikas 7.1"),
      controller: null,
      unlocked_until: null,
      dropped_parameters: [],
      absent: [],
      checking: false,
      plan: { wanted: [] },
    },
  } as unknown as Partial<State>;
  /** The program's next message: its state, with what differs. */
  const say = (more: Partial<State> = {}) => {
    const message: Partial<LiveMessage> = { now: 100, dropped: 0, state: { ...line, ...more } as State };
    socket.onmessage!.call({} as WebSocket, { data: JSON.stringify(message) } as MessageEvent);
  };
  const show = <Props extends Record<string, unknown>>(component: Component<Props>, props: Props) =>
    render(PageRig as unknown as Component<Record<string, unknown>>, { props: { stores, component, props } });
  return { asked, say, show, socket, stores };
}

/** An answer that the API gives to what it refuses. */
export const refused = (status: number, code: string) =>
  new Response(JSON.stringify({ error: { code, ...words(`Advice on ${code}`) } }), { status });
