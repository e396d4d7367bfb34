import { beforeEach, expect, it, vi } from "vitest";
import { saveSetting } from "../lib/platform/storage";
import type { State } from "../lib/api/types";
import { Interrupted } from "./interrupted";

const FTDI = "webserial:0403:6001";
const MINUTE = 60_000;

let interrupted = new Interrupted();

beforeEach(() => {
  interrupted = new Interrupted();
  saveSetting("recording.amid", "");
  vi.stubGlobal("location", { hash: "" });
});

const at = (port: string | null, file: string | null) => ({ port, recording: file && { file, failure: null } }) as unknown as State;

/** What the next page does, on which the browser allows `ports`. */
function nextPage(...ports: string[]) {
  const done: string[] = [];
  const live = { state: { line: "off", recording: null } as unknown as State };
  const offers: { text: string; run?: () => void }[] = [];
  const note =
    (what: string) =>
    (...given: string[]) =>
      Promise.resolve(void done.push([what, ...given].join(" ")));
  const app = {
    live,
    api: { ports: () => Promise.resolve({ ports: ports.map((url) => ({ url })) }) },
    connection: {
      connect: (port: string) => note("connect")(port).then(() => (live.state = { ...live.state, line: "no-port" })),
      choose: note("choose"),
    },
    recordingControl: { toggle: note("record") },
    route: { go: note("show"), later: () => note("show") },
    toasts: {
      attempt: (job: () => Promise<unknown>) => job(),
      refuse: (text: () => string, { action }: { action?: { run: () => void } }) => void offers.push({ text: text(), run: action?.run }),
    },
  };
  const began = new Interrupted().began(app as unknown as Parameters<Interrupted["began"]>[0]);
  return { began, done, offers };
}

it("a recording that was cut short is named, its car is connected again, and it can be continued", async () => {
  interrupted.follow(at(FTDI, "drive.pcapng"), Date.now());
  const { began, done, offers } = nextPage(FTDI);
  expect(began).toBe(true);
  await vi.waitFor(() => expect(done).toEqual(["show live", `connect ${FTDI}`]));
  expect(offers[0]!.text).toContain("drive.pcapng is kept");
  offers[0]!.run!();
  await vi.waitFor(() => expect(done.slice(2)).toEqual(["record", "show live"]));
});

it("an adapter that the browser has forgotten is chosen when a person continues, not before", async () => {
  interrupted.follow(at(`${FTDI}?baud=9600`, "drive.pcapng"), Date.now());
  const { done, offers } = nextPage("webserial:1a86:7523");
  await vi.waitFor(() => expect(done).toEqual(["show live"]));
  offers[0]!.run!();
  await vi.waitFor(() => expect(done).toEqual(["show live", "choose", "record"]));
});

it.each([[`${FTDI}?baud=9600`], ["sim:?scenario=city"]])("%s is connected with its options", async (port) => {
  interrupted.follow(at(port, "drive.pcapng"), Date.now());
  const { done } = nextPage(FTDI);
  await vi.waitFor(() => expect(done).toContain(`connect ${port}`));
});

it("it is said once", () => {
  interrupted.follow(at(FTDI, "drive.pcapng"), Date.now());
  expect([nextPage(FTDI).began, nextPage(FTDI).began]).toEqual([true, false]);
});

it("whoever returns an hour later only reads that it was cut short", () => {
  interrupted.follow(at(FTDI, "old.pcapng"), Date.now() - 60 * MINUTE);
  const { began, done, offers } = nextPage(FTDI);
  expect([began, done, offers.length, offers[0]!.run]).toEqual([false, [], 1, undefined]);
});

it("the time of the last note counts, not that of the beginning", () => {
  interrupted.follow(at(FTDI, "long.pcapng"), Date.now() - 60 * MINUTE);
  interrupted.follow(at(FTDI, "long.pcapng"), Date.now() - MINUTE);
  expect(nextPage(FTDI).began).toBe(true);
});

it("a recording that has ended, or has broken off, is none", () => {
  interrupted.follow(at(FTDI, "drive.pcapng"), Date.now());
  interrupted.follow(at(FTDI, null), Date.now());
  expect(nextPage(FTDI).offers).toEqual([]);
  interrupted.follow(at(FTDI, "full.pcapng"), Date.now());
  interrupted.follow({ port: FTDI, recording: { file: "full.pcapng", failure: { en: "", ru: "" } } } as unknown as State, Date.now());
  expect(nextPage(FTDI).offers).toEqual([]);
});

it.each(["", "{", "null", "[]", '{"file": 1, "port": "sim:", "seen": 0}'])("a note that is none, %s, says nothing", (damaged) => {
  saveSetting("recording.amid", damaged);
  expect(nextPage(FTDI).offers).toEqual([]);
});
