// A test over the recording that is shown: the request, which can be cancelled, and its answer.
import { ApiRequest } from "../../lib/api/request.svelte";
import type { RecordedTest, TestInfo } from "../../lib/api/types";
import type { ApiClient } from "../../lib/api/api";

export class RecordedTests {
  readonly request = new ApiRequest<RecordedTest>();
  /** The test that is done or was done; null: none. */
  test = $state.raw<TestInfo | null>(null);
  recording = $state<string | null>(null);
  private stop = new AbortController();

  constructor(private readonly api: ApiClient) {}

  async run(recording: string, test: TestInfo): Promise<void> {
    this.clear();
    this.test = test;
    this.recording = recording;
    const { signal } = this.stop;
    await this.request.run(() => this.api.recordedTest(recording, test.name, signal));
  }

  /** Cancel the work, or put the answer away. */
  clear(): void {
    this.stop.abort();
    this.stop = new AbortController();
    this.request.reset();
    this.test = this.recording = null;
  }
}
