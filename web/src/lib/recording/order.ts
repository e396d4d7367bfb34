// Order and search of the list. Newest first.

import type { Recording } from "../api/types";

/** Recordings without a date come last. */
export function newestFirst(recordings: readonly Recording[]): Recording[] {
  return [...recordings].sort((one, other) => {
    const a = one.date ?? -Infinity;
    const b = other.date ?? -Infinity;
    if (a === b) return one.id < other.id ? 1 : -1;
    return b - a;
  });
}

/** Recordings that contain every word of `wanted` in the file name, car, plate, workshop, unit, passport, faults or note. */
export function matching(recordings: readonly Recording[], wanted: string): Recording[] {
  const words = wanted.toLowerCase().split(/\s+/).filter(Boolean);
  return recordings.filter((it) => {
    const parts = [
      it.id,
      it.model?.en,
      it.model?.ru,
      it.note,
      it.car.car,
      it.car.plate,
      it.car.workshop,
      ...(it.passport ?? []),
      ...(it.faults ?? []),
    ];
    const text = parts.join(" ").toLowerCase();
    return words.every((word) => text.includes(word));
  });
}
