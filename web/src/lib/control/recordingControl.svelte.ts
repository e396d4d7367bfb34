// Start and stop a recording and set a marker, from any screen (keys R and M).
import { api } from "../api/api";
import { dictionary } from "../i18n";
import { catalog } from "../api/catalog.svelte";
import { live } from "../live/live.svelte";
import { supportedNames, subscriptions } from "./subscriptions.svelte";
import { attempt, toasts } from "../view/toasts.svelte";
import type { State } from "../api/types";

const t = dictionary({
  started: {
    en: "Recording {sampled} of {all} values: a script has reduced the sampling plan",
    ru: "Записываются {sampled} из {all} величин: план опроса сократила другая программа",
  },
  startedAll: { en: "Recording all values to {file}", ru: "Идёт запись всех величин в {file}" },
  allValues: { en: "Record all values", ru: "Записывать всё" },
  everythingNow: { en: "All values are recorded now", ru: "Теперь записываются все величины" },
  stopped: { en: "Recording saved: {file}", ru: "Запись сохранена: {file}" },
  marked: { en: "Marker set", ru: "Отметка поставлена" },
  unrecorded: { en: "Marker set on the chart; no recording is running", ru: "Отметка поставлена на графике; запись не идёт" },
});

/** Code of the toast that a recording has started; the toast is dismissed when the recording ends. */
const STARTED = "RecordingStarted";

/** Announce that a recording has ended and is stored. */
export function announceSaved(file: string): void {
  toasts.dismiss(new Set([STARTED]));
  toasts.success(() => t("stopped", { file }));
}

class RecordingControl {
  busy = $state(false);

  async toggle(): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    const file = live.state?.recording?.file;
    const state = await attempt(() => (file ? api.stopRecording() : api.startRecording()));
    this.busy = false;
    if (!state) return;
    if (file) announceSaved(file);
    else if (state.recording) {
      this.announceStarted(state, state.recording.file);
    }
  }

  /** Everything is recorded, unless a script has reduced the plan: say so then, and offer to record all. */
  private announceStarted(state: State, file: string): void {
    const supported = supportedNames(catalog.channels, state);
    const wanted = new Set(state.plan.wanted.map(({ name }) => name));
    const [sampled, all] = [supported.filter((name) => wanted.has(name)).length, supported.length];
    if (sampled === all) return toasts.success(() => t("startedAll", { file }));
    toasts.success(() => t("started", { file, sampled, all }), {
      duration: 12_000,
      code: STARTED,
      action: { text: () => t("allValues"), run: () => void this.recordAll() },
    });
  }

  private async recordAll(): Promise<void> {
    if (await subscriptions.subscribeAll()) toasts.success(() => t("everythingNow"));
  }

  async mark(label = ""): Promise<void> {
    const recorded = live.state?.recording != null;
    if (await attempt(() => api.marker(label))) toasts.success(() => t(recorded ? "marked" : "unrecorded"));
  }
}

export const recordingControl = new RecordingControl();
