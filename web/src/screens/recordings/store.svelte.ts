// The list of recordings; kept while another screen is shown, refreshed when it is opened.
import { api } from "../../lib/api/api";
import { ApiRequest } from "../../lib/api/request.svelte";
import type { About, LeftOutFile, Recording, Text } from "../../lib/api/types";

class RecordingStore {
  readonly list = new ApiRequest<Recording[]>();
  readonly about = new ApiRequest<About>();
  search = $state("");
  /** Why the folder can't store recordings. */
  problem = $state.raw<Text | null>(null);
  leftOut = $state.raw<readonly LeftOutFile[]>([]);

  async refresh(): Promise<void> {
    if (!this.about.value) void this.about.run(() => api.about());
    await this.list.run(async () => {
      const answer = await api.recordings();
      this.problem = answer.problem;
      this.leftOut = answer.left_out;
      return answer.recordings;
    });
  }

  /** Update a saved note without loading the list again. */
  noted(id: string, note: string): void {
    this.list.value = (this.list.value ?? []).map((it) => (it.id === id ? { ...it, note } : it));
  }
}

export const recordings = new RecordingStore();
