/**
 * Which bytes changed since they were last read, and when: a changed byte glows for two seconds.
 * What was not read before has not changed.
 */

export const GLOW_MS = 2000;

export class Glow {
  #values = new Map<number, number>();
  #changed = new Map<number, number>();

  /** Takes bytes that were read at `now` (ms); returns how many differ from what was known. */
  take(data: Uint8Array, first: number, now: number): number {
    let count = 0;
    data.forEach((value, at) => {
      const address = first + at;
      const known = this.#values.get(address);
      if (known !== undefined && known !== value) {
        this.#changed.set(address, now);
        count++;
      }
      this.#values.set(address, value);
    });
    return count;
  }

  /** Addresses that still glow at `now`; forgets the others. */
  at(now: number): Set<number> {
    for (const [address, time] of this.#changed) {
      if (now - time >= GLOW_MS) this.#changed.delete(address);
    }
    return new Set(this.#changed.keys());
  }

  /** ms until the next byte stops glowing; null: none glows. */
  next(now: number): number | null {
    let next: number | null = null;
    for (const time of this.#changed.values()) {
      const left = Math.max(0, time + GLOW_MS - now);
      next = next === null ? left : Math.min(next, left);
    }
    return next;
  }

  /** Another space, or another unit: nothing is known. */
  reset(): void {
    this.#values.clear();
    this.#changed.clear();
  }
}
