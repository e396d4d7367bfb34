import { describe, expect, it } from "vitest";
import { Columns } from "../series/columns";
import { Pairs, type PairPlan } from "./pairs";
import { randoms } from "../../../test/random";

type Row = { time: number; values: Record<string, number | null> };

function columnsOf(rows: readonly Row[], names: readonly string[], capacity?: number): Columns {
  const columns = new Columns(capacity);
  columns.append(
    names,
    rows.map(({ time }) => time),
    names.map((name) => rows.map(({ values }) => values[name] ?? null)),
  );
  return columns;
}

/** The rule, written without regard to time: every row looks back over all rows before it. */
function naive(rows: readonly Row[], plan: PairPlan, gaps: readonly number[]): { pairs: (number | null)[][]; left: number } {
  const within = rows.filter(({ time }) => !plan.span || (time >= plan.span[0] && time <= plan.span[1]));
  const pairs: (number | null)[][] = [];
  let left = 0;
  within.forEach(({ time, values }, at) => {
    const own = values[plan.name] ?? null;
    if (own === null) return;
    const others = plan.partners.map(({ name }) => {
      const source = within.slice(0, at + 1).findLast((row) => (row.values[name] ?? null) !== null);
      if (!source) return null;
      if (source.time === time) return source.values[name]!;
      const broken = gaps.some((gap) => gap >= source.time && gap < time);
      return time - source.time <= plan.age && !broken ? source.values[name]! : null;
    });
    if (others.some((value, index) => value === null && plan.partners[index]!.needed)) left += 1;
    else pairs.push([time, own, ...others]);
  });
  return { pairs, left };
}

const listed = (pairs: Pairs) =>
  Array.from({ length: pairs.length }, (_, at) => [
    pairs.times[at]!,
    ...pairs.values.map((column) => (Number.isNaN(column[at]!) ? null : column[at]!)),
  ]);

describe("pairs", () => {
  it("are what the rule says, for random rows read in random portions", () => {
    const next = randoms(7);
    for (let round = 0; round < 60; round += 1) {
      let time = 1000;
      const names = ["A", "B", "C"];
      const rows = Array.from({ length: 120 }, () => {
        time += 0.05 + (next() < 0.05 ? 3 * next() : 0.2 * next());
        return {
          time,
          values: Object.fromEntries(names.map((name, at) => [name, next() < 0.3 * (at + 1) ? null : Math.round(100 * next())])),
        };
      });
      const gaps = rows.filter(() => next() < 0.05).map((row) => row.time + (next() < 0.5 ? 0 : 0.01));
      const plan: PairPlan = {
        name: names[Math.floor(next() * 3)]!,
        partners: [
          { name: names[Math.floor(next() * 3)]!, needed: true },
          { name: names[Math.floor(next() * 3)]!, needed: next() < 0.5 },
        ],
        age: [0, 0.2, 1, 5][Math.floor(next() * 4)]!,
        span: next() < 0.5 ? null : [rows[20]!.time, rows[90]!.time - 0.001],
      };
      const columns = columnsOf(rows, names);
      const pairs = new Pairs(plan);
      while (pairs.read(columns, gaps, 1 + Math.floor(next() * 40)));
      const expected = naive(rows, plan, gaps);
      expect(listed(pairs)).toEqual(expected.pairs);
      expect(pairs.left).toBe(expected.left);
    }
  });

  it("grow with the columns: reading later rows gives what reading all at once does", () => {
    const rows = Array.from({ length: 5000 }, (_, at) => ({ time: at / 10, values: { A: at % 3 ? at : null, B: at % 7 ? null : at } }));
    const plan: PairPlan = { name: "A", partners: [{ name: "B", needed: true }], age: 0.4, span: null };
    const columns = new Columns();
    const growing = new Pairs(plan);
    for (let at = 0; at < rows.length; at += 37) {
      const part = rows.slice(at, at + 37);
      columns.append(
        ["A", "B"],
        part.map(({ time }) => time),
        [part.map(({ values }) => values.A), part.map(({ values }) => values.B)],
      );
      while (growing.read(columns, [], 10));
    }
    const once = new Pairs(plan);
    while (once.read(columns, [], 1 << 20));
    expect(listed(growing)).toEqual(listed(once));
    expect(growing.length).toBeGreaterThan(2000);
    expect(growing.share(columns)).toBe(1);
  });

  it("know that rows were dropped", () => {
    const columns = columnsOf([{ time: 1, values: { A: 1 } }], ["A"], 8);
    const pairs = new Pairs({ name: "A", partners: [], age: 0, span: null });
    pairs.read(columns, [], 100);
    expect(pairs.isOutdated(columns)).toBe(false);
    columns.append(["A"], [2, 3, 4, 5, 6, 7, 8, 9], [[2, 3, 4, 5, 6, 7, 8, 9]]);
    expect(pairs.isOutdated(columns)).toBe(true);
  });
});
