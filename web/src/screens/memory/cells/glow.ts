// Which bytes changed since they were last read, and when: a changed byte glows for two seconds. A byte read for the first time has not
// changed.

export const GLOW_MS = 2000;

export class Glow {
  #values = new Map<number, number>();
  #changed = new Map<number, number>();

  /** Add bytes that were read at `now` (ms) and return how many differ from the previous ones. */
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

  /** Addresses that glow at `now`; expired ones are dropped. */
  at(now: number): Set<number> {
    for (const [address, time] of this.#changed) {
      if (now - time >= GLOW_MS) this.#changed.delete(address);
    }
    return new Set(this.#changed.keys());
  }

  /** ms until the next byte stops glowing; null: none glows. */
  next(now: number): number | null {
    if (this.#changed.size === 0) return null;
    return Math.max(0, Math.min(...this.#changed.values()) + GLOW_MS - now);
  }

  /** Forget all bytes, for another space or ECU. */
  reset(): void {
    this.#values.clear();
    this.#changed.clear();
  }
}
