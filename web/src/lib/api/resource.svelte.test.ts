import { flushSync } from "svelte";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { ApiError } from "./http";
import { Resource } from "./resource.svelte";

const ends: (() => void)[] = [];
beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("document", { hidden: false });
});
afterEach(() => {
  for (const end of ends.splice(0)) end();
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

/** Need a resource as a component does; returns what ends that. */
function need(resource: { need(): unknown }): () => void {
  const end = $effect.root(() => void resource.need());
  ends.push(end);
  flushSync();
  return end;
}

const refusal = new ApiError(503, "Busy", { en: "busy", ru: "занято" });

/** A question that fails so many times, and the seconds at which it was asked. */
function failing(times: number) {
  const asked: number[] = [];
  const began = Date.now();
  const ask = async () => {
    asked.push((Date.now() - began) / 1000);
    if (asked.length <= times) throw refusal;
    return "there";
  };
  return { asked, ask };
}

/** Questions that wait for their answers. */
function waiting() {
  const asked: { key: string; signal: AbortSignal; answer: (value: string) => void; fail: (error: Error) => void }[] = [];
  const ask = (key: string, signal: AbortSignal) => new Promise<string>((answer, fail) => void asked.push({ key, signal, answer, fail }));
  const settled = () => vi.advanceTimersByTimeAsync(0);
  return { asked, ask, settled };
}

describe("what a screen can't do without", () => {
  it("is asked for again after 1, 2, 4, 8 s until it comes", async () => {
    const { asked, ask } = failing(5);
    const resource = new Resource({ of: () => true, ask, insists: true });
    need(resource);
    await vi.advanceTimersByTimeAsync(120_000);
    expect(asked).toEqual([0, 1, 3, 7, 15, 23]);
    expect([resource.value, resource.error]).toEqual(["there", null]);
  });

  it("is not asked for again before the response has come", async () => {
    const { asked, ask } = waiting();
    need(new Resource({ of: () => "a", ask, insists: true }));
    await vi.advanceTimersByTimeAsync(60_000);
    expect(asked.length).toBe(1);
    asked[0]!.fail(refusal);
    await vi.advanceTimersByTimeAsync(1000);
    expect(asked.length).toBe(2);
  });

  it("is not asked for again when no component needs it, even while it is being asked for", async () => {
    const { asked, ask } = failing(Infinity);
    need(new Resource({ of: () => true, ask, insists: true }))();
    await vi.advanceTimersByTimeAsync(60_000);
    expect(asked).toEqual([0]);
  });
});

describe("data that belong to a key", () => {
  it("are asked for once, however often the state comes", async () => {
    let state = $state.raw({ unit: "A", rate: 0 });
    const { asked, ask, settled } = waiting();
    const resource = new Resource({ of: () => state.unit, ask });
    need(resource);
    asked[0]!.answer("of A");
    await settled();
    for (let rate = 1; rate <= 20; rate += 1) {
      state = { unit: "A", rate };
      flushSync();
    }
    expect([asked.length, resource.value]).toEqual([1, "of A"]);
  });

  it("are dropped with the key, and a late answer of the key before does not come", async () => {
    let unit = $state<string | null>("A");
    const { asked, ask, settled } = waiting();
    const resource = new Resource({ of: () => unit, ask });
    need(resource);
    unit = "B";
    flushSync();
    expect([asked.map(({ key }) => key), asked[0]!.signal.aborted]).toEqual([["A", "B"], true]);
    asked[1]!.answer("of B");
    await settled();
    asked[0]!.answer("of A");
    await settled();
    expect(resource.value).toBe("of B");
    unit = "C";
    flushSync();
    expect([resource.value, resource.busy]).toEqual([null, true]);
    unit = null; // nothing to ask for
    flushSync();
    asked[2]!.answer("of C");
    await settled();
    expect([resource.value, resource.busy]).toEqual([null, false]);
  });

  it("stay until the next have come, if they are only asked for again", async () => {
    let version = $state(1);
    const { asked, ask, settled } = waiting();
    const resource = new Resource({ of: () => "A", again: () => version, ask });
    need(resource);
    asked[0]!.answer("first");
    await settled();
    version = 2;
    flushSync();
    expect([asked.length, resource.value]).toEqual([2, "first"]);
    asked[1]!.fail(refusal);
    await settled();
    expect([resource.value, resource.error]).toEqual(["first", refusal]);
  });

  it("are asked for again by a component that comes later, unless once is enough", async () => {
    for (const [once, questions] of [
      [undefined, 2],
      [true, 1],
    ] as const) {
      const { asked, ask, settled } = waiting();
      const resource = new Resource({ of: () => "A", ask, once });
      const end = need(resource);
      asked[0]!.answer("there");
      await settled();
      end();
      need(resource);
      expect([asked.length, resource.value]).toEqual([questions, "there"]);
    }
  });

  it("are asked for every so often while the page is visible, and not while a question waits", async () => {
    const { asked, ask, settled } = waiting();
    let every = $state(1000);
    need(new Resource({ of: () => "A", ask, every: () => every }));
    await vi.advanceTimersByTimeAsync(3500);
    expect(asked.length).toBe(1);
    asked[0]!.answer("there");
    await settled();
    await vi.advanceTimersByTimeAsync(600);
    expect(asked.length).toBe(2);
    asked[1]!.answer("there");
    vi.stubGlobal("document", { hidden: true });
    await vi.advanceTimersByTimeAsync(5000);
    expect(asked.length).toBe(2);
    vi.stubGlobal("document", { hidden: false });
    every = 0;
    flushSync();
    await vi.advanceTimersByTimeAsync(5000);
    expect(asked.length).toBe(2);
  });

  it("wait for the last key", async () => {
    let typed = $state("F");
    const { asked, ask } = waiting();
    need(new Resource({ of: () => typed, ask, wait: 200 }));
    for (const next of ["FR", "FRE", "FREQ"]) {
      typed = next;
      flushSync();
      await vi.advanceTimersByTimeAsync(150);
    }
    await vi.advanceTimersByTimeAsync(100);
    expect(asked.map(({ key }) => key)).toEqual(["FREQ"]);
  });
});
