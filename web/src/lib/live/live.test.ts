import { afterEach, expect, it, vi } from "vitest";
import type { History } from "../api/types";
import { served } from "../platform/host";
import { Stores } from "../../stores";

const { api, live } = new Stores(served);

const history = (value: number) => ({ names: ["A"], times: [1, 2], values: [[value, value]], events: [] }) as unknown as History;

afterEach(() => {
  live.columns.clear();
  live.extremes.clear();
  live.extremesFrom = null;
});

it("a channel that is changed while the history is loaded has the values of the change, and no others", async () => {
  const answers: ((history: History) => void)[] = [];
  vi.spyOn(api, "history").mockImplementation(() => new Promise((resolve) => void answers.push(resolve)));
  const answer = async (value: number) => {
    const { length } = answers;
    answers.at(-1)!(history(value));
    await vi.waitFor(() => expect(answers.length).toBe(length + 1));
  };
  live.reload(["A"]);
  await answer(1);
  live.reload(["A"]);
  await answer(1);
  await answer(5);
  answers.at(-1)!(history(5));
  await vi.waitFor(() => expect([...(live.columns.column("A") ?? [])]).toEqual([5, 5]));
  expect(live.extremes.get("A")).toEqual({ min: 5, max: 5 });
});
