// The journal of changes. Each change has two entries, before and after, so that an interrupted one is visible; here the two become one
// line.

import type { Channel, Journal, Text } from "../../lib/api/types";
import { compile } from "../memory/cells/formula";

export type RawEntry = Journal["entries"][number];

export interface Entry extends RawEntry {
  /** The erased faults; null for other changes. */
  codes: number[] | null;
}

/** What the two entries of a change have in common. */
const keyOf = ({ port, command, change, before }: RawEntry) => JSON.stringify([port, command, change, before]);

/** Merge the two entries of each change. Newest first, as the server sends them. */
export function mergeEntries(entries: readonly RawEntry[]): Entry[] {
  const out: Entry[] = [];
  const ends: string[] = [];
  for (const entry of entries) {
    const key = keyOf(entry);
    if (entry.state === "started") {
      const at = ends.indexOf(key);
      if (at >= 0) {
        ends.splice(at, 1);
        continue; // its result is in the list
      }
    } else {
      ends.push(key);
    }
    out.push(entryOf(entry));
  }
  return out;
}

const entryOf = (entry: RawEntry): Entry => ({ ...entry, codes: /^erase\b/i.test(entry.change.en) ? codesOf(entry.before) : null });

/** Fault codes from `0D 35`. */
export const codesOf = (before: string | null | undefined): number[] =>
  (before?.match(/[0-9a-f]{2}/gi) ?? []).map((byte) => parseInt(byte, 16));

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

export function changeText(change: Text): Text {
  if (change.ru !== change.en) return change;
  const known = RUSSIAN.find(([pattern]) => pattern.test(change.en));
  return known ? { en: change.en, ru: change.en.replace(...known) } : change;
}

/** The name of the parameter that was written; null: another change. */
export const parameterOf = (change: Text): string | null => /^write parameter (\S+)$/.exec(change.en)?.[1] ?? null;

/** The value of these bytes by the catalog's formula; null: no bytes, or no number. */
export function valueOf(bytes: string, channel: Pick<Channel, "formula" | "size" | "flag">): number | null {
  if (channel.flag || !/^([0-9A-F]{2} ?)+$/i.test(bytes)) return null;
  const data = Uint8Array.from(bytes.match(/[0-9A-F]{2}/gi)!, (byte) => parseInt(byte, 16));
  return data.length === channel.size ? compile(channel.formula).value(data) : null;
}
