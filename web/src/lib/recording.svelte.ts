// The two verbs of a recording that work on every screen: R and M.
import { api } from "./api";
import { dictionary } from "./i18n";
import { live } from "./live.svelte";
import { attempt, toasts } from "./toasts.svelte";

const t = dictionary({
  started: { en: "Recording: {file}", ru: "Идёт запись: {file}" },
  stopped: { en: "Recorded: {file}", ru: "Записано: {file}" },
  marked: { en: "Marked", ru: "Отмечено" },
  unrecorded: { en: "Marked on the chart; nothing is being recorded", ru: "Отмечено на графике; запись не идёт" },
});

class RecordingKeys {
  busy = $state(false);

  async toggle(): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    const file = live.state?.recording?.file;
    const state = await attempt(() => (file ? api.stopRecording() : api.startRecording()));
    this.busy = false;
    if (!state) return;
    if (file) toasts.done(() => t("stopped", { file }));
    else if (state.recording) {
      const begun = state.recording.file;
      toasts.done(() => t("started", { file: begun }));
    }
  }

  async mark(label = ""): Promise<void> {
    const recorded = live.state?.recording != null;
    if (await attempt(() => api.marker(label))) toasts.done(() => t(recorded ? "marked" : "unrecorded"));
  }
}

export const recordingKeys = new RecordingKeys();
