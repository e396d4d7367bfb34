/** The table's order and search. Newest first is what one looks for after a drive. */

import type { Recording } from "../../lib/api/types";

/** What has no date stands at the end. */
export function newestFirst(recordings: readonly Recording[]): Recording[] {
  return [...recordings].sort((one, other) => {
    const a = one.date ?? -Infinity;
    const b = other.date ?? -Infinity;
    if (a === b) return one.id < other.id ? 1 : -1;
    return b - a;
  });
}

/** Every word of `wanted` somewhere in the file's name, the car, its passport, its faults or the note. */
export function matching(recordings: readonly Recording[], wanted: string): Recording[] {
  const words = wanted.toLowerCase().split(/\s+/).filter(Boolean);
  return recordings.filter((it) => {
    const parts = [
      it.id,
      it.model?.en,
      it.model?.ru,
      it.note,
      ...(it.passport ?? []),
      ...(it.faults ?? []),
    ];
    const text = parts.join(" ").toLowerCase();
    return words.every((word) => text.includes(word));
  });
}
