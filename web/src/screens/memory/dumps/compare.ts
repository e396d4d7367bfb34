// Compares two dumps by address: rows of sixteen, one row of context around each difference; equal parts between are one line with their
// length.

import { WIDTH } from "../cells/hex";

export interface Side {
  first: number;
  data: Uint8Array;
}

export interface PairRow {
  kind: "row";
  address: number;
  a: (number | null)[];
  b: (number | null)[];
  differs: boolean[];
}

export interface EqualRows {
  kind: "equal";
  address: number;
  bytes: number;
}

export interface Comparison {
  /** Addresses where both have a byte, and the bytes differ. */
  different: number;
  /** Addresses where only one has a byte. */
  onlyA: number;
  onlyB: number;
  equal: number;
  lines: (PairRow | EqualRows)[];
  /** Rows with differences beyond the maximum. */
  left: number;
}

function byteAt(side: Side, address: number): number | null {
  const at = address - side.first;
  return at >= 0 && at < side.data.length ? (side.data[at] ?? null) : null;
}

export function compare(a: Side, b: Side, most = 400): Comparison {
  const result: Comparison = { different: 0, onlyA: 0, onlyB: 0, equal: 0, lines: [], left: 0 };
  const start = Math.min(a.first, b.first);
  const end = Math.max(a.first + a.data.length, b.first + b.data.length);
  const rows: PairRow[] = [];
  for (let address = start - (start % WIDTH); address < end; address += WIDTH) {
    rows.push(pair(a, b, address, result));
  }
  const changed = rows.map((row) => row.differs.includes(true));
  let equal: EqualRows | null = null;
  let count = 0;
  rows.forEach((row, at) => {
    const near = changed[at - 1] || changed[at] || changed[at + 1];
    if (near && count < most) {
      equal = null;
      result.lines.push(row);
      count++;
    } else if (changed[at]) {
      result.left++;
    } else if (count < most) {
      if (!equal) {
        equal = { kind: "equal", address: row.address, bytes: 0 };
        result.lines.push(equal);
      }
      equal.bytes += row.a.filter((cell) => cell !== null).length;
    }
  });
  return result;
}

function pair(a: Side, b: Side, address: number, result: Comparison): PairRow {
  const row: PairRow = { kind: "row", address, a: [], b: [], differs: [] };
  for (let at = address; at < address + WIDTH; at++) {
    const left = byteAt(a, at);
    const right = byteAt(b, at);
    row.a.push(left);
    row.b.push(right);
    row.differs.push(left !== right);
    if (left === right) result.equal += left === null ? 0 : 1;
    else if (right === null) result.onlyA++;
    else if (left === null) result.onlyB++;
    else result.different++;
  }
  return row;
}
