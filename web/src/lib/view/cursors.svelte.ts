// The chart's two cursors, shared with the player, which loops between them. Times; null: not there.

class Cursors {
  a = $state<number | null>(null);
  b = $state<number | null>(null);

  /** From the earlier to the later, if there are two. */
  get between(): [number, number] | null {
    if (this.a === null || this.b === null || this.a === this.b) return null;
    return [Math.min(this.a, this.b), Math.max(this.a, this.b)];
  }
}

export const cursors = new Cursors();
