// The tests, the running one and the results of this unit. The run is asked for while the screen is shown.
import { Resource } from "../../lib/api/resource.svelte";
import { t } from "./messages";
import type { TestRun } from "../../lib/api/types";
import type { Stores } from "../../stores";

/** Milliseconds between two questions while a test runs, and while none does: another page may start one. */
const RUNNING = 250;
const IDLE = 2000;

export class Tests {
  readonly list = new Resource({ of: () => this.app.live.linked, again: () => this.app.live.later, ask: () => this.app.api.tests() });
  readonly results = new Resource({
    of: () => this.app.live.linked,
    again: () => this.app.live.later,
    ask: () => this.app.api.testResults(),
  });
  run = $state.raw<TestRun | null>(null);
  busy = $state(false);
  /** Counts what this page changes: an answer to a question of before is of the run before. */
  private changes = 0;

  constructor(private readonly app: Pick<Stores, "api" | "live" | "toasts">) {}

  /** Follow the run until the returned function is called. */
  follow(): () => void {
    let stopped = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const ask = async () => {
      const { changes } = this;
      try {
        const { run } = await this.app.api.testRun();
        if (changes === this.changes) {
          if (this.run && !this.run.result && !run) this.app.toasts.refuse(() => t("ended"), { duration: 20_000 });
          this.take(run);
        }
      } catch {
        // The band shows a lost program; the next question may be answered.
      }
      if (!stopped) timer = setTimeout(() => void ask(), this.run && !this.run.result ? RUNNING : IDLE);
    };
    void ask();
    return () => {
      stopped = true;
      clearTimeout(timer);
    };
  }

  async refresh(): Promise<void> {
    await Promise.all([this.list.reload(), this.results.reload()]);
  }

  /** Start a test; a finished one is put away. */
  start = (name: string) => this.change(() => this.app.api.startTest(name));
  skip = () => this.change(() => this.app.api.skipTestStep());
  async cancel(): Promise<void> {
    await this.change(() => this.app.api.cancelTest());
    void this.refresh();
  }

  async putInReport(id: string, wanted: boolean): Promise<void> {
    const kept = await this.app.toasts.attempt(() => this.app.api.testInReport(id, wanted));
    if (!kept) return;
    if (this.run?.result?.id === id) this.run = { ...this.run, result: kept };
    await this.refresh();
  }

  private async change(job: () => Promise<{ run: TestRun | null }>): Promise<void> {
    this.busy = true;
    this.changes += 1;
    const state = await this.app.toasts.attempt(job);
    this.changes += 1;
    this.busy = false;
    if (state) this.take(state.run);
  }

  private take(run: TestRun | null): void {
    const finished = run?.result != null && this.run?.result == null;
    this.run = run;
    if (finished) void this.refresh();
  }
}
