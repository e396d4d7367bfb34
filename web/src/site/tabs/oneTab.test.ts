import { beforeEach, expect, it, vi } from "vitest";
import type { Refusal } from "../boot/start.svelte";
import { OneTab, type Owner } from "./oneTab";

/** Web Locks of one name, as browsers have them: a queue, and one that steals. */
class FakeLocks {
  private holder: ((error: Error) => void) | null = null;
  private readonly queue: (() => void)[] = [];

  request(_name: string, options: LockOptions, run: (lock: Lock | null) => unknown): Promise<unknown> {
    return new Promise((done, fail) => {
      const take = () => {
        this.holder = fail;
        void run({} as Lock);
      };
      if (options.steal) {
        this.holder?.(new DOMException("stolen", "AbortError"));
        take();
      } else if (this.holder === null) take();
      else if (options.ifAvailable) done(run(null));
      else {
        this.queue.push(take);
        options.signal?.addEventListener("abort", () => {
          this.queue.splice(this.queue.indexOf(take), 1);
          fail(options.signal!.reason);
        });
      }
    });
  }

  /** The tab that has the lock is closed. */
  close(): void {
    this.holder = null;
    this.queue.shift()?.();
  }
}

let locks: FakeLocks;
let channels: { onmessage: ((event: MessageEvent) => void) | null; postMessage(data: unknown): void }[];

function tab(refusal: Refusal | null = null) {
  const channel = {
    onmessage: null as ((event: MessageEvent) => void) | null,
    postMessage(data: unknown) {
      for (const other of channels) if (other !== channel) queueMicrotask(() => other.onmessage?.({ data } as MessageEvent));
    },
  };
  channels.push(channel);
  const owner = { refusal: vi.fn(() => refusal), leave: vi.fn(), restart: vi.fn() } satisfies Owner;
  const one = new OneTab(locks as unknown as LockManager, channel as unknown as BroadcastChannel);
  const [elsewhere, mine] = [vi.fn(), vi.fn()];
  void one.become(owner, elsewhere).then(mine);
  return { one, owner, elsewhere, mine, channel };
}

const settled = async () => {
  for (let turn = 0; turn < 20; turn += 1) await Promise.resolve();
};

beforeEach(() => {
  locks = new FakeLocks();
  channels = [];
});

it("the first tab has the program; the next says so, and has it when the first is closed", async () => {
  const [first, second] = [tab(), tab()];
  await settled();
  expect(first.mine).toHaveBeenCalledOnce();
  expect(first.elsewhere).not.toHaveBeenCalled();
  expect([second.mine.mock.calls.length, second.elsewhere.mock.calls.length]).toEqual([0, 1]);
  locks.close();
  await settled();
  expect(second.mine).toHaveBeenCalledOnce();
});

it("a tab that is asked leaves the program, and to the one that asked, whoever waits before it", async () => {
  const [first, waiting, asking] = [tab(), tab(), tab()];
  await settled();
  expect(await asking.one.ask()).toBe(null);
  await settled();
  expect(first.owner.leave).toHaveBeenCalledOnce();
  expect(first.owner.restart).toHaveBeenCalledOnce();
  expect(asking.mine).toHaveBeenCalledOnce();
  expect(waiting.mine).not.toHaveBeenCalled();
});

it("it is refused while the first tab needs it", async () => {
  const [first, second] = [tab("recording"), tab()];
  await settled();
  expect(await second.one.ask()).toBe("recording");
  expect(first.owner.leave).not.toHaveBeenCalled();
  locks.close();
  await settled();
  expect(second.mine).toHaveBeenCalledOnce();
});

it("a tab that does not answer keeps it", async () => {
  vi.useFakeTimers();
  const [first, second] = [tab(), tab()];
  await settled();
  first.channel.onmessage = null;
  const answer = second.one.ask();
  await vi.advanceTimersByTimeAsync(10_000);
  expect(await answer).toBe("silent");
  vi.useRealTimers();
});

it("a tab goes on when the one that asked was closed meanwhile", async () => {
  vi.useFakeTimers();
  const first = tab();
  await settled();
  first.channel.onmessage!({ data: { kind: "leave", from: "gone" } } as MessageEvent);
  await vi.advanceTimersByTimeAsync(10_000);
  expect(first.owner.restart).toHaveBeenCalledOnce();
  vi.useRealTimers();
});
