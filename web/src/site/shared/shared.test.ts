import { beforeEach, expect, it, vi } from "vitest";
import { Inbox, type News } from "./inbox";
import { Incoming } from "./incoming.svelte";
import { receive } from "./receive";

const SITE = new URL("https://host.example/tools/mikas/");

class FakeCache {
  readonly kept = new Map<string, Response>();
  room = Infinity;

  async put(address: string, response: Response): Promise<void> {
    if (this.kept.size >= this.room) throw new DOMException("the disk is full", "QuotaExceededError");
    this.kept.set(address, response);
  }
  keys = async (): Promise<string[]> => [...this.kept.keys()];
  match = async (address: string): Promise<Response | undefined> => this.kept.get(address)?.clone();
  delete = async (address: string): Promise<boolean> => this.kept.delete(address);
}

let cache: FakeCache;
let opened: string[];
let inbox: Inbox;

beforeEach(() => {
  cache = new FakeCache();
  opened = [];
  const caches = { open: async (name: string) => (opened.push(name), cache) };
  inbox = new Inbox(SITE, caches as unknown as CacheStorage);
});

const file = (name: string, content = name) => new File([content], name);

async function emptied(): Promise<[string, string][]> {
  const got: [string, string][] = [];
  await inbox.empty(async (it) => got.push([it.name, await it.text()]));
  return got;
}

it("files wait under their names, in their order, and are given once", async () => {
  expect(await inbox.put([file("Поездка.pcapng", "a"), file("b.pcapng.txt", "b")])).toBe("some");
  expect(await inbox.put([file("c.pcapng", "c")])).toBe("some");
  expect(opened.every((name) => name === "mikas-shared /tools/mikas/")).toBe(true); // no kept files of a version: those are forgotten
  const all = [
    ["Поездка.pcapng", "a"],
    ["b.pcapng.txt", "b"],
    ["c.pcapng", "c"],
  ];
  expect(await emptied()).toEqual(all);
  expect(await emptied()).toEqual([]);
});

it("a file stays until it was added: a tab that is closed amid that loses none", async () => {
  await inbox.put([file("a"), file("b")]);
  await expect(inbox.empty(() => Promise.reject(new Error("closed")))).rejects.toThrow("closed");
  expect((await emptied()).length).toBe(2);
});

it("without room nothing of a share is kept, and the page says why", async () => {
  await inbox.put([file("before")]);
  cache.room = 2;
  expect(await inbox.put([file("a"), file("b")])).toBe("full");
  expect(await emptied()).toEqual([["before", "before"]]);
});

const shared = async (fill: (form: FormData) => void): Promise<[number, string]> => {
  const form = new FormData();
  fill(form);
  const answer = await receive(new Request(`${SITE.href}shared`, { method: "POST", body: form }), SITE, inbox);
  return [answer.status, answer.headers.get("location") ?? ""];
};

it("a share is kept by the service worker and leads to the page", async () => {
  const heard = new BroadcastChannel("mikas.shared");
  const news = new Promise((came) => (heard.onmessage = ({ data }: MessageEvent) => came(data)));
  expect(await shared((form) => form.append("recordings", file("a.pcapng")))).toEqual([303, `${SITE.href}?shared=some#/recordings`]);
  expect(await news).toBe("some");
  heard.close();
  expect(await emptied()).toEqual([["a.pcapng", "a.pcapng"]]);
});

it("a share without a file, without room, and one that can't be read each have their address", async () => {
  const address = (news: News) => [303, `${SITE.href}?shared=${news}#/recordings`];
  expect(await shared((form) => form.append("text", "https://host.example"))).toEqual(address("none"));
  expect(await shared((form) => form.append("recordings", file("", "")))).toEqual(address("none"));
  cache.room = 0;
  expect(await shared((form) => form.append("recordings", file("a")))).toEqual(address("full"));
  const broken = await receive({ formData: () => Promise.reject(new TypeError("no form")) }, SITE, inbox);
  expect([broken.status, broken.headers.get("location")]).toEqual(address("failed"));
});

type Channel = ConstructorParameters<typeof Incoming>[1];
const channel = (): Channel => ({ postMessage: vi.fn(), onmessage: null });

function page(search = "") {
  let consumer: (launch: { files?: { getFile(): Promise<File> }[] }) => void = () => undefined;
  const it = {
    location: { search, pathname: "/tools/mikas/", hash: "#/recordings" },
    history: { replaceState: vi.fn() },
    launchQueue: { setConsumer: (given: typeof consumer) => (consumer = given) },
  };
  return {
    it: it as never,
    history: it.history,
    open: (...files: File[]) => consumer({ files: files.map((each) => ({ getFile: async () => each })) }),
  };
}

it("the tab that has the program adds what is there, what comes, and what another tab was given", async () => {
  await inbox.put([file("before.pcapng")]);
  const [mine, other] = [channel(), channel()];
  const [owner, second] = [new Incoming(inbox, mine), new Incoming(inbox, other)];
  const added: string[] = [];
  owner.attend(async ({ name }) => added.push(name), vi.fn());
  await vi.waitFor(() => expect(added).toEqual(["before.pcapng"]));
  const shown = page();
  second.watch(shown.it);
  shown.open();
  expect(second.news).toBe(null); // an ordinary start
  shown.open(file("opened.pcapng"));
  await vi.waitFor(() => expect(other.postMessage).toHaveBeenCalledExactlyOnceWith("some"));
  expect(second.news).toBe("some");
  expect(added).toEqual(["before.pcapng"]);
  mine.onmessage!.call({} as BroadcastChannel, { data: "some" } as MessageEvent);
  mine.onmessage!.call({} as BroadcastChannel, { data: "some" } as MessageEvent);
  await vi.waitFor(() => expect(added).toEqual(["before.pcapng", "opened.pcapng"]));
});

it("what came to a tab is in its address once: a reload says nothing", () => {
  const shown = page("?shared=full");
  const incoming = new Incoming(inbox, channel());
  incoming.watch(shown.it);
  expect(incoming.news).toBe("full");
  expect(shown.history.replaceState).toHaveBeenCalledExactlyOnceWith(null, "", "/tools/mikas/#/recordings");
  const others = new Incoming(inbox, channel());
  others.watch(page("?shared=<b>").it);
  expect(others.news).toBe(null);
});

it("a file that can't be read, and a browser without a cache, are said", async () => {
  const shown = page();
  const incoming = new Incoming(null, channel());
  incoming.watch(shown.it);
  shown.open(file("a.pcapng"));
  await vi.waitFor(() => expect(incoming.news).toBe("failed"));
});
