import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { WakeLock } from "./wakeLock.svelte";

class Sentinel extends EventTarget {
  released = false;
  release = vi.fn(() => {
    this.released = true;
    this.dispatchEvent(new Event("release"));
    return Promise.resolve();
  });
}

class Page extends EventTarget {
  hidden = false;
}

let page: Page;
let given: Sentinel[];
let request: () => Promise<Sentinel>;

beforeEach(() => {
  given = [];
  request = () => {
    given.push(new Sentinel());
    return Promise.resolve(given.at(-1)!);
  };
  vi.stubGlobal("document", (page = new Page()));
  vi.stubGlobal("navigator", { wakeLock: { request: () => request() } });
});
afterEach(() => void vi.unstubAllGlobals());

const settled = () => new Promise((done) => setImmediate(done));

async function turn(hidden: boolean) {
  page.hidden = hidden;
  page.dispatchEvent(new Event("visibilitychange"));
  await settled();
}

it("the screen that the browser let go while the page was hidden is kept on again, whoever let it go", async () => {
  const lock = new WakeLock();
  lock.want(true);
  await settled();
  expect(lock.state).toBe("held");
  await given[0]!.release(); // as the browser does
  await turn(true);
  expect([lock.state, given.length]).toEqual(["off", 1]);
  await turn(false);
  expect([lock.state, given.length]).toEqual(["held", 2]);
  await turn(true);
  expect(given[1]!.released).toBe(true);
  lock.want(false);
  await turn(false);
  expect([lock.state, given.length]).toEqual(["off", 2]);
});

it("a refusal does no harm, and is asked again when the page is seen again", async () => {
  const lock = new WakeLock();
  const allowed = request;
  request = () => Promise.reject(new DOMException("nearly empty", "NotAllowedError"));
  lock.want(true);
  await settled();
  expect(lock.state).toBe("refused");
  request = allowed;
  await turn(true);
  await turn(false);
  expect(lock.state).toBe("held");
});

it("a lock that can't be given back does no harm", async () => {
  const lock = new WakeLock();
  lock.want(true);
  await settled();
  given[0]!.release.mockRejectedValue(new DOMException("gone", "InvalidStateError"));
  lock.want(false);
  await settled();
  expect(lock.state).toBe("off");
});

it("a browser without it only says so", async () => {
  vi.stubGlobal("navigator", {});
  const lock = new WakeLock();
  lock.want(true);
  await settled();
  expect(lock.state).toBe("refused");
});
