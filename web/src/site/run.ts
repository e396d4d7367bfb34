// The ordinary page over the program in this tab: what the host is, and what ends with the tab.
import { mount } from "svelte";
import { background } from "./background.svelte";
import { connectByItself } from "./byItself.svelte";
import { answerDownloads } from "./offline/downloads";
import { interrupted } from "./interrupted";
import { updates } from "./offline/updates.svelte";
import App from "../App.svelte";
import "../styles/tokens.css";
import "../styles/base.css";
import "uplot/dist/uPlot.min.css";
import type { State } from "../lib/api/types";
import { holdsAdapter } from "../lib/live/lineState";
import { served, type Host } from "../lib/platform/host";
import { Stores } from "../stores";
import ConnectionNotices from "./notices/ConnectionNotices.svelte";
import ThisBrowser from "./notices/ThisBrowser.svelte";
import { canChoose, choosePort, findAdapters } from "./notices/adapters.svelte";
import { accessHere } from "./usb/access";
import { storage } from "./notices/storage.svelte";
import { incoming } from "./shared/incoming.svelte";
import { t as ts } from "./shared/messages";
import type { Program } from "./program/program";
import type { Owner } from "./tabs/oneTab";
import { unkept, words } from "./words";

export function run(program: Program, owner: Owner, target: Element): void {
  const host: Host = {
    ...served,
    fetch: program.fetch,
    connect: program.connect,
    // It starts for seconds, and does one thing at a time: while it reads a long recording, nothing else comes.
    patience: { first: Infinity, next: 15_000 },
    runsHere: true,
    reachesAdapters: canChoose(),
    feedsAdapters: accessHere() === "usb",
    choosePort: canChoose() ? choosePort : null,
    sharesNetwork: false,
    exports: ["csv", "msl", "mlg", "gpx", "geojson"],
    words,
    connectionNotices: ConnectionNotices,
    connectionCard: ThisBrowser,
    get opensAddresses() {
      return navigator.serviceWorker?.controller != null;
    },
  };
  const stores = new Stores(host);
  const { live } = stores;

  /** What the program does; null: it has stopped. */
  const state = () => (live.link === "lost" ? null : live.state);
  owner.refusal = () => (state()?.recording ? "recording" : state()?.line === "sampling" ? "sampling" : null);
  /** Whether leaving would end what goes on. A phone is left by a careless swipe, so there the connection counts as well. */
  const goesOn = (now: State | null) => now !== null && (now.recording !== null || (host.feedsAdapters && holdsAdapter(now)));
  window.addEventListener("beforeunload", (event) => goesOn(state()) && event.preventDefault());
  // Other pages and programs may have the adapter then; a page that the browser has kept takes it again.
  window.addEventListener("pagehide", () => program.line.release(true));
  window.addEventListener("pageshow", ({ persisted }) => persisted && program.line.release(false));
  void storage.look().then(() => storage.kept || (host.words = { ...words, kept: unkept }));
  const usual = live.onfirst;
  live.onfirst = (first) => {
    if (interrupted.began(stores)) return;
    usual(first);
    connectByItself(stores);
  };
  findAdapters();
  answerDownloads(program.fetch, stores);
  void updates.watch(live);
  incoming.attend(
    (file) => stores.recordings.add([file]),
    (news) => stores.toasts.error(() => ts(news)),
  );
  background(program, stores);
  mount(App, { target, props: { stores } });
}
