import { afterEach, expect, it, vi } from "vitest";
import type { TestRun, TestRunState } from "../../lib/api/types";
import { served } from "../../lib/platform/host";
import { Stores } from "../../stores";

const { api, tests, toasts } = new Stores(served);

const run = { phase: "start", result: null } as unknown as TestRun;

afterEach(() => {
  tests.run = null;
  toasts.shown = [];
  vi.useRealTimers();
});

it("a test that was started is not replaced by the answer to a question of before", async () => {
  vi.useFakeTimers();
  let answer = (_: TestRunState) => {};
  vi.spyOn(api, "testRun").mockImplementation(() => new Promise((resolve) => (answer = resolve)));
  vi.spyOn(api, "startTest").mockResolvedValue({ run } as TestRunState);
  const stop = tests.follow();
  await tests.start("idle");
  expect(tests.run).toBe(run);
  answer({ run: null } as TestRunState);
  await vi.advanceTimersByTimeAsync(0);
  expect(tests.run).toBe(run);
  await vi.advanceTimersByTimeAsync(250); // the next question is of this run
  answer({ run: null } as TestRunState);
  await vi.advanceTimersByTimeAsync(0);
  expect(tests.run).toBe(null);
  expect(toasts.shown.map(({ text }) => text())).toEqual([expect.stringContaining("without a verdict")]);
  stop();
});
