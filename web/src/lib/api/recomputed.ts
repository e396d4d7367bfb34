// Which channels have other values by another catalog.
import type { Catalog, Channel } from "./types";

const computation = ({ formula, constants, accumulates, code, size }: Channel) =>
  JSON.stringify([formula, constants, accumulates, code, size]);

/** The channels that one of the catalogs lacks or computes otherwise, and those that are computed from these. */
export function recomputed(before: Catalog, after: Catalog): string[] {
  const of = (catalog: Catalog) => new Map([...catalog.parameters, ...catalog.derived].map((each) => [each.name, each]));
  const [old, next] = [of(before), of(after)];
  const changed = new Set<string>();
  for (const name of new Set([...old.keys(), ...next.keys()])) {
    const [was, is] = [old.get(name), next.get(name)];
    if (!was || !is || computation(was) !== computation(is)) changed.add(name);
  }
  for (let size = -1; size !== changed.size;) {
    size = changed.size;
    for (const channel of next.values()) {
      if (channel.inputs?.some((input) => changed.has(input))) changed.add(channel.name);
    }
  }
  return [...changed];
}
