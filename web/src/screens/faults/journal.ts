// The journal of changes. Each change has two entries, before and after, so that an interrupted one is visible; here the two become one
// line.

import type { Channel, Text } from "../../lib/api/types";
import { compile } from "../memory/cells/formula";

export interface RawEntry {
  time: number;
  change: string | Text;
  state: string;
  before?: unknown;
  after?: unknown;
  outcome?: unknown;
  command?: string;
  safety?: string;
  port?: string;
  model?: string | Text;
  [more: string]: unknown;
}

export interface Entry {
  time: number;
  change: string | Text;
  /** `started`: the result is unknown. */
  state: string;
  before: unknown;
  after: unknown;
  outcome: unknown;
  model: string | Text | null;
  erase: boolean;
  /** The erased faults; null for other changes. */
  codes: number[] | null;
}

function same(a: RawEntry, b: RawEntry): boolean {
  return (
    a.port === b.port &&
    a.command === b.command &&
    JSON.stringify(a.change) === JSON.stringify(b.change) &&
    JSON.stringify(a.before ?? null) === JSON.stringify(b.before ?? null)
  );
}

/** Merge the two entries of each change. Newest first, as the server sends them. */
export function mergeEntries(entries: readonly RawEntry[]): Entry[] {
  const out: Entry[] = [];
  const ends: RawEntry[] = [];
  for (const entry of entries) {
    if (entry.state === "started") {
      const at = ends.findIndex((end) => same(end, entry));
      if (at >= 0) {
        ends.splice(at, 1);
        continue; // its result is in the list
      }
    } else {
      ends.push(entry);
    }
    out.push(entryOf(entry));
  }
  return out;
}

function entryOf(entry: RawEntry): Entry {
  const change = typeof entry.change === "string" ? entry.change : (entry.change?.en ?? "");
  const erase = /^erase\b/i.test(change);
  return {
    time: entry.time,
    change: entry.change,
    state: entry.state,
    before: entry.before ?? null,
    after: entry.after ?? null,
    outcome: entry.outcome ?? null,
    model: entry.model ?? null,
    erase,
    codes: erase ? codesOf(entry.before) : null,
  };
}

/** Fault codes from `0D 35`, `[13, 53]` or `[{"code": 13}]`. */
export function codesOf(before: unknown): number[] {
  if (typeof before === "string") {
    const found = before.match(/[0-9a-f]{2}/gi) ?? [];
    return found.map((byte) => parseInt(byte, 16));
  }
  if (!Array.isArray(before)) return [];
  return before
    .map((it: unknown) => {
      if (typeof it === "number") return it;
      const code = (it as { code?: unknown } | null)?.code;
      return typeof code === "number" ? code : NaN;
    })
    .filter((code) => Number.isInteger(code));
}

/** Older entries are in English only; these are their Russian forms. */
const RUSSIAN: readonly (readonly [RegExp, string])[] = [
  [/^write (\d+) byte\(s\) to (.+)$/, "записать байтов: $1, $2"],
  [/^write parameter (.+)$/, "записать параметр $1"],
  [/^write (\w+)$/, "записать $1"],
  [/^set the unit's list to (\d+) code\(s\)$/, "задать список блока, кодов: $1"],
  [/^erase (\d+) stored fault\(s\)$/, "сбросить ошибки, всего: $1"],
  [/^jump to (.+)$/, "перейти на $1"],
  [/^send (.+)$/, "послать $1"],
];

export function changeText(change: string | Text): Text {
  const en = typeof change === "string" ? change : change.en;
  if (typeof change !== "string" && change.ru !== en) return change;
  for (const [pattern, russian] of RUSSIAN) {
    if (pattern.test(en)) return { en, ru: en.replace(pattern, russian) };
  }
  return { en, ru: en };
}

/** The name of the parameter that was written; null: another change. */
export function parameterOf(change: string | Text): string | null {
  const en = typeof change === "string" ? change : change.en;
  return /^write parameter (\S+)$/.exec(en)?.[1] ?? null;
}

/** The value of these bytes by the catalog's formula; null: no bytes, or no number. */
export function valueOf(bytes: unknown, channel: Pick<Channel, "formula" | "size" | "flag">): number | null {
  if (typeof bytes !== "string" || channel.flag || !/^([0-9A-F]{2} ?)+$/i.test(bytes)) return null;
  const data = Uint8Array.from(bytes.match(/[0-9A-F]{2}/gi)!, (byte) => parseInt(byte, 16));
  return data.length === channel.size ? compile(channel.formula).value(data) : null;
}
