// The list of recordings; kept while another screen is shown, refreshed when it is opened.
import { ApiRequest } from "../../lib/api/request.svelte";
import { Resource } from "../../lib/api/resource.svelte";
import { t } from "./messages";
import type { LeftOutFile, Recording, Text } from "../../lib/api/types";
import type { Stores } from "../../stores";

export class RecordingStore {
  /** Asked for again when a recording starts or ends, and when the connection returns. */
  readonly list = new Resource({
    of: () => this.app.live.linked,
    again: () => this.app.live.state?.recording?.file,
    ask: async () => {
      const answer = await this.app.api.recordings();
      this.problem = answer.problem;
      this.leftOut = answer.left_out;
      return answer.recordings;
    },
  });
  readonly references = new Resource({
    of: () => this.app.live.linked,
    again: () => this.app.live.state?.recording?.file,
    ask: () => this.app.api.references(),
  });
  search = $state("");
  /** Why the folder can't store recordings. */
  problem = $state.raw<Text | null>(null);
  leftOut = $state.raw<readonly LeftOutFile[]>([]);
  readonly opening = new ApiRequest<void>();
  /** The recording that is being opened, or was. */
  opened = $state("");

  constructor(private readonly app: Pick<Stores, "api" | "live" | "player" | "route" | "toasts">) {}

  /** For a component that shows the list. */
  need(): void {
    for (const each of [this.list, this.references]) each.need();
  }

  async refresh(): Promise<void> {
    await Promise.all([this.list.reload(), this.references.reload()]);
  }

  /** Add recordings made elsewhere, one after the other; those that can't be are said. */
  async add(files: readonly File[]): Promise<void> {
    let added = 0;
    for (const file of files) if (await this.app.toasts.attempt(() => this.app.api.addRecording(file.name, file))) added += 1;
    if (added > 0) this.app.toasts.success(() => t("added", { n: added }));
    await this.refresh();
  }

  /** Show a recording in place of the live data. */
  async show(id: string): Promise<void> {
    const { player } = this.app;
    const go = this.app.route.later();
    this.opened = id;
    this.opening.reset();
    await this.opening.run(() => player.open(id));
    // Only this screen shows why it can't be opened.
    if (this.opening.error) go("recordings");
    else if (player.detail?.id === id) go("live");
  }

  /** Mark a recording as a reference, or remove its mark. */
  async mark(id: string, on: boolean): Promise<void> {
    const answer = await this.app.toasts.attempt(() => this.app.api.markReference(id, on));
    if (!answer) return;
    this.references.value = answer;
    this.update(id, { reference: on });
  }

  /** Leave a deleted recording out at once; the list itself may take a while to come. */
  dropDeleted(id: string): void {
    this.list.value = this.list.value?.filter((it) => it.id !== id) ?? null;
    void this.refresh();
  }

  /** Show what was saved without loading the list again. */
  update(id: string, changed: Partial<Recording>): void {
    this.list.value = this.list.value?.map((it) => (it.id === id ? { ...it, ...changed } : it)) ?? null;
  }
}
