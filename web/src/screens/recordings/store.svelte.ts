// The list of recordings; kept while another screen is shown, refreshed when it is opened.
import { untrack } from "svelte";
import { ApiRequest } from "../../lib/api/request.svelte";
import { t } from "./messages";
import type { About, LeftOutFile, Recording, References, Text } from "../../lib/api/types";
import type { ApiClient } from "../../lib/api/api";
import type { Toasts } from "../../lib/frame/toasts.svelte";

export class RecordingStore {
  readonly list = new ApiRequest<Recording[]>();
  readonly references = new ApiRequest<References>();
  readonly about = new ApiRequest<About>();
  search = $state("");
  /** Why the folder can't store recordings. */
  problem = $state.raw<Text | null>(null);
  leftOut = $state.raw<readonly LeftOutFile[]>([]);

  constructor(
    private readonly api: ApiClient,
    private readonly toasts: Toasts,
  ) {}

  async refresh(): Promise<void> {
    // Called in effects, which must not run again when it has come.
    if (!untrack(() => this.about.value)) void this.about.run(() => this.api.about());
    void this.references.run(() => this.api.references());
    await this.list.run(async () => {
      const answer = await this.api.recordings();
      this.problem = answer.problem;
      this.leftOut = answer.left_out;
      return answer.recordings;
    });
  }

  /** Add recordings made elsewhere, one after the other; those that can't be are said. */
  async add(files: readonly File[]): Promise<void> {
    let added = 0;
    for (const file of files) if (await this.toasts.attempt(() => this.api.addRecording(file.name, file))) added += 1;
    if (added > 0) this.toasts.success(() => t("added", { n: added }));
    await this.refresh();
  }

  /** Mark a recording as a reference, or remove its mark. */
  async mark(id: string, on: boolean): Promise<void> {
    const answer = await this.toasts.attempt(() => this.api.markReference(id, on));
    if (!answer) return;
    this.references.value = answer;
    this.update(id, { reference: on });
  }

  /** Update a saved note without loading the list again. */
  noted(id: string, note: string): void {
    this.update(id, { note });
  }

  private update(id: string, changed: Partial<Recording>): void {
    this.list.value = this.list.value?.map((it) => (it.id === id ? { ...it, ...changed } : it)) ?? null;
  }
}
