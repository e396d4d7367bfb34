// The watch list: memory cells with name and formula, stored in this browser. Neighbouring cells are read with one request, which costs
// less than two.

import { compile } from "./formula";
import { SPACES, type SpaceName } from "./hex";

export interface Cell {
  id: string;
  space: SpaceName;
  address: number;
  name: string;
  formula: string;
  unit: string;
}

export interface Read {
  space: SpaceName;
  address: number;
  count: number;
  cells: Cell[];
}

/** Bytes between two cells that cost less than a second request (4 + 5 bytes of framing, §5). */
const GAP = 9;
const LONGEST_READ = 255;
const MOST = 40;

/** A new cell without a name. Over plain HTTP there is no randomUUID. */
export function newCell(space: SpaceName, address: number): Cell {
  const id = [...crypto.getRandomValues(new Uint8Array(8))].map((it) => it.toString(16)).join("-");
  return { id, space, address, name: "", formula: "b", unit: "" };
}

/** Null: the formula is invalid. */
function compiled({ formula }: Cell): ReturnType<typeof compile> | null {
  try {
    return compile(formula);
  } catch {
    return null;
  }
}

const sizeOf = (cell: Cell): number => compiled(cell)?.size ?? 1;

export function readsFor(cells: readonly Cell[]): Read[] {
  const reads: Read[] = [];
  for (const space of SPACES) {
    const here = cells.filter((cell) => cell.space === space.name).sort((a, b) => a.address - b.address);
    for (const cell of here) {
      const end = Math.min(cell.address + sizeOf(cell), space.last + 1);
      const last = reads.at(-1);
      const near =
        last?.space === space.name &&
        !space.single &&
        cell.address <= last.address + last.count + GAP &&
        end - last.address <= LONGEST_READ;
      if (last && near) {
        last.count = Math.max(last.count, end - last.address);
        last.cells.push(cell);
      } else {
        reads.push({ space: space.name, address: cell.address, count: end - cell.address, cells: [cell] });
      }
    }
  }
  return reads;
}

/** The cell's bytes from the data of a read. */
export function bytesOf(cell: Cell, read: Read, data: Uint8Array): Uint8Array {
  const from = cell.address - read.address;
  return data.subarray(from, from + sizeOf(cell));
}

/** The cell's value; null: invalid formula, too few bytes, or no number. */
export const valueOf = (cell: Cell, bytes: Uint8Array): number | null => compiled(cell)?.value(bytes) ?? null;

/** The stored list without its invalid entries. */
export function restored(text: string | null): Cell[] {
  let stored: unknown;
  try {
    stored = JSON.parse(text ?? "[]");
  } catch {
    return [];
  }
  if (!Array.isArray(stored)) return [];
  return stored.filter(isCell).slice(0, MOST);
}

function isCell(it: unknown): it is Cell {
  if (typeof it !== "object" || it === null) return false;
  const cell = Object.fromEntries<unknown>(Object.entries(it));
  const texts = ["id", "name", "formula", "unit"].every((key) => typeof cell[key] === "string");
  const space = SPACES.find(({ name }) => name === cell.space);
  if (!texts || !space) return false;
  const address = cell.address;
  return typeof address === "number" && Number.isInteger(address) && address >= 0 && address <= space.last;
}
