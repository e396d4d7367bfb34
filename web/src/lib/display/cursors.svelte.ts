// The chart's two cursors as times (null: not set). The player loops between them.

export class Cursors {
  a = $state<number | null>(null);
  b = $state<number | null>(null);

  /** From the earlier to the later; null unless both are set. */
  get between(): [number, number] | null {
    if (this.a === null || this.b === null || this.a === this.b) return null;
    return [Math.min(this.a, this.b), Math.max(this.a, this.b)];
  }
}
