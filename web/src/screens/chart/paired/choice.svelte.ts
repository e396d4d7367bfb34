// What Scatter and Table show: channels, edges, statistic. Stored in this browser.
import { loadSetting, saveSetting } from "../../../lib/platform/storage";
import { MOST_BINS } from "../../../lib/pairs/bins";
import { STATISTICS, type Statistic } from "../../../lib/pairs/cells";

export const AGES = [0, 0.2, 0.5, 1, 2, 5] as const;
const MOST_LEAST = 10_000;

interface Stored {
  scatter: { x: string; y: string; colour: string };
  table: { x: string; y: string; value: string };
  statistic: Statistic;
  least: number;
  age: number;
  /** The edges that a person gave, by channel. */
  edges: Record<string, number[]>;
}

/** `colour` "": by the number of readings. */
const FIRST: Stored = {
  scatter: { x: "FREQ", y: "JAIR", colour: "THR" },
  table: { x: "FREQ", y: "JAIR", value: "UOZ" },
  statistic: "mean",
  least: 3,
  age: 1,
  edges: {},
};

/** The settings in a stored text; where one is missing or not valid, the default. */
export function readChoice(text: string | null): Stored {
  let given: Partial<Stored> = {};
  try {
    // eslint-disable-next-line @typescript-eslint/consistent-type-assertions -- each part is checked below
    given = (JSON.parse(text ?? "") ?? {}) as Partial<Stored>;
  } catch {
    return structuredClone(FIRST);
  }
  const names = <Group extends Record<string, string>>(group: Partial<Group> | undefined, first: Group): Group =>
    // eslint-disable-next-line @typescript-eslint/consistent-type-assertions -- the keys are those of `first`
    Object.fromEntries(Object.entries(first).map(([key, name]) => [key, typeof group?.[key] === "string" ? group[key] : name])) as Group;
  const sound = (edges: unknown) =>
    Array.isArray(edges) &&
    edges.length >= 2 &&
    edges.length <= MOST_BINS + 1 &&
    edges.every((edge, at) => Number.isFinite(edge) && (at === 0 || edge > edges[at - 1]));
  return {
    scatter: names(given.scatter, FIRST.scatter),
    table: names(given.table, FIRST.table),
    statistic: STATISTICS.find((it) => it === given.statistic) ?? FIRST.statistic,
    least: leastOf(given.least) ?? FIRST.least,
    age: AGES.find((it) => it === given.age) ?? FIRST.age,
    edges: Object.fromEntries(Object.entries(given.edges ?? {}).filter(([, edges]) => sound(edges))),
  };
}

/** A least count as it was given; null if it is none. */
export function leastOf(given: unknown): number | null {
  const least = Number(given);
  return given !== "" && Number.isInteger(least) && least >= 1 && least <= MOST_LEAST ? least : null;
}

export class Choice {
  now = $state.raw<Stored>(readChoice(loadSetting("pairs")));

  change(change: Partial<Stored>): void {
    this.now = { ...this.now, ...change };
    saveSetting("pairs", JSON.stringify(this.now));
  }

  /** null: the defaults of the catalog again. */
  setEdges(name: string, edges: number[] | null): void {
    const others = Object.entries(this.now.edges).filter(([each]) => each !== name);
    this.change({ edges: Object.fromEntries(edges ? [...others, [name, edges]] : others) });
  }
}
