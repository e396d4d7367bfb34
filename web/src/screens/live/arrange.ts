// Reordering of tiles.
import type { Tile } from "../../lib/api/types";

/** A key for each tile, which it keeps when it is moved, or shown as another kind. Equal tiles have different ones. */
export function keysOf(tiles: readonly Pick<Tile, "names">[]): string[] {
  const before = new Map<string, number>();
  return tiles.map(({ names }) => {
    const name = names.join();
    const count = before.get(name) ?? 0;
    before.set(name, count + 1);
    return `${name} ${count}`;
  });
}

export function moved<Item>(items: readonly Item[], from: number, to: number): Item[] {
  const rest = items.filter((_, at) => at !== from);
  const item = items[from];
  if (item === undefined) return [...items];
  return [...rest.slice(0, to), item, ...rest.slice(to)];
}

interface Box {
  left: number;
  right: number;
  top: number;
  bottom: number;
}

/** The box under a point, else the nearest one; null without boxes. */
export function placeAt(boxes: readonly Box[], x: number, y: number): number | null {
  let best: number | null = null;
  let nearest = Infinity;
  boxes.forEach((box, index) => {
    const across = Math.max(box.left - x, 0, x - box.right);
    const down = Math.max(box.top - y, 0, y - box.bottom);
    const distance = across * across + down * down;
    if (distance < nearest) {
      nearest = distance;
      best = index;
    }
  });
  return best;
}
