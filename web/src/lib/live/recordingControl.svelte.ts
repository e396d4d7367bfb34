// The two verbs of a recording that work on every screen: R and M.
import { api } from "../api/api";
import { dictionary } from "../i18n";
import { catalog } from "../api/catalog.svelte";
import { live } from "./live.svelte";
import { everyName, needs } from "./subscriptions.svelte";
import { attempt, toasts } from "../view/toasts.svelte";
import type { State } from "../api/types";

const t = dictionary({
  started: {
    en: "Recording {asked} of {all} values: what is asked for now",
    ru: "Записываются {asked} из {all} величин: что сейчас опрашивается",
  },
  startedAll: { en: "Recording to {file}: all values", ru: "Идёт запись в {file}: все величины" },
  everything: { en: "Record everything", ru: "Записывать всё" },
  everythingNow: { en: "All values are recorded now, each less often", ru: "Записываются все величины, каждая реже" },
  stopped: { en: "Recorded, and kept: {file}", ru: "Записано и сохранено: {file}" },
  marked: { en: "Marked", ru: "Отмечено" },
  unrecorded: { en: "Marked on the chart; nothing is being recorded", ru: "Отмечено на графике; запись не идёт" },
});

/** Of the message that a recording has begun: when it has ended, that is of the past. */
const BEGUN = "RecordingBegun";

/** It has ended, and is in the list. */
export function kept(file: string): void {
  toasts.mended(new Set([BEGUN]));
  toasts.done(() => t("stopped", { file }));
}

class RecordingKeys {
  busy = $state(false);

  async toggle(): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    const file = live.state?.recording?.file;
    const state = await attempt(() => (file ? api.stopRecording() : api.startRecording()));
    this.busy = false;
    if (!state) return;
    if (file) kept(file);
    else if (state.recording) {
      this.begun(state, state.recording.file);
    }
  }

  /** Only what is asked for goes into it: said, and more is one touch away. */
  private begun(state: State, file: string): void {
    const every = everyName(catalog.channels, state);
    const asked = state.plan.wanted.length;
    const all = Math.max(asked, every.length);
    if (asked === all) return toasts.done(() => t("startedAll", { file }));
    toasts.done(() => t("started", { file, asked, all }), {
      lasts: 12_000,
      code: BEGUN,
      action: { text: () => t("everything"), run: () => void this.widen() },
    });
  }

  private async widen(): Promise<void> {
    if (await needs.everything()) toasts.done(() => t("everythingNow"));
  }

  async mark(label = ""): Promise<void> {
    const recorded = live.state?.recording != null;
    if (await attempt(() => api.marker(label))) toasts.done(() => t(recorded ? "marked" : "unrecorded"));
  }
}

export const recordingKeys = new RecordingKeys();
