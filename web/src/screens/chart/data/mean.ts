// The mean of the values between two times; null without values.
import type { Columns } from "../../../lib/series/columns";

export function meanOf(columns: Columns, name: string, from: number, to: number): number | null {
  const column = columns.column(name, columns.rowAt(from) + 1, columns.rowAt(to) + 1);
  let sum = 0;
  let count = 0;
  for (const value of column ?? []) {
    if (Number.isNaN(value)) continue;
    sum += value;
    count += 1;
  }
  return count > 0 ? sum / count : null;
}
