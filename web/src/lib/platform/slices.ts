// Long computations in slices of a frame, so that the page stays responsive.

/** ms of a frame for the computation; drawing and input need the rest. */
const BUDGET = 7;

export class Slices {
  private frame = 0;

  /** `step` does a small part and returns whether more is left; `after` is called after each slice. */
  constructor(
    private readonly step: () => boolean,
    private readonly after: (finished: boolean) => void,
  ) {}

  /** Go on in the next frame. */
  request(): void {
    if (!this.frame) this.frame = requestAnimationFrame(() => this.run());
  }

  stop(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
  }

  private run(): void {
    this.frame = 0;
    const end = performance.now() + BUDGET;
    let more = this.step();
    while (more && performance.now() < end) more = this.step();
    this.after(!more);
    if (more) this.request();
  }
}
