// Start and stop a recording, from any screen (key R).
import { dictionary } from "../i18n";
import { opening } from "../live/lineState";
import { supportedNames } from "./subscriptions.svelte";
import type { State } from "../api/types";
import type { Stores } from "../../stores";

const t = dictionary({
  started: {
    en: "Recording {sampled} of {all} values: a script has reduced the sampling plan",
    ru: "Записываются {sampled} из {all} величин: план опроса сократила другая программа",
  },
  startedAll: { en: "Recording all values to {file}", ru: "Идёт запись всех величин в {file}" },
  allValues: { en: "Record all values", ru: "Записывать всё" },
  everythingNow: { en: "All values are recorded now", ru: "Теперь записываются все величины" },
  stopped: { en: "Recording saved: {file}", ru: "Запись сохранена: {file}" },
  open: { en: "Open", ru: "Открыть" },
  lost: { en: "Nothing can be recorded: the program does not answer", ru: "Записать нельзя: программа не отвечает" },
  view: {
    en: "This page may only view; recordings are started at the computer with the cable",
    ru: "Здесь доступен только просмотр; запись включают на компьютере с кабелем",
  },
  off: { en: "Connect first: there is nothing to record yet", ru: "Сначала подключитесь: записывать пока нечего" },
  "no-port": { en: "Nothing to record: the port is not open", ru: "Записывать нечего: порт не открыт" },
  "no-echo": { en: "Nothing to record: no response, not even an echo", ru: "Записывать нечего: нет ответа, даже эха" },
  "echo-only": { en: "Nothing to record: the ECU does not answer", ru: "Записывать нечего: блок не отвечает" },
});

/** Code of the toast that a recording has started; the toast is dismissed when the recording ends. */
const STARTED = "RecordingStarted";

/** Code of the toast that says why none can be started. */
const REFUSED = "RecordingRefused";

/** ms for which a message with an offer is shown. */
const OFFER_MS = 12_000;

export class RecordingControl {
  busy = $state(false);

  constructor(private readonly app: Pick<Stores, "api" | "catalog" | "live" | "subscriptions" | "carDetails" | "toasts" | "recordings">) {}

  /** Why no recording can be started now, in words; null: it can. */
  get refusal(): string | null {
    const state = this.app.live.state;
    if (this.app.live.link === "lost" || !state) return t("lost");
    if (state.rights === "view") return t("view");
    // While the port is being opened the program waits for the unit, and records from its first values on.
    return state.line === "sampling" || state.line === "ecu-alive" || opening(state) ? null : t(state.line);
  }

  async toggle(): Promise<void> {
    if (this.busy) return;
    const file = this.app.live.state?.recording?.file;
    const refusal = this.refusal;
    if (!file && refusal !== null) return this.app.toasts.refuse(() => this.refusal ?? refusal, { code: REFUSED });
    this.busy = true;
    const state = await this.app.toasts.attempt(() => (file ? this.app.api.stopRecording() : this.app.api.startRecording()));
    this.busy = false;
    if (!state) return;
    if (file) this.announceSaved(file);
    else if (state.recording) {
      this.announceStarted(state, state.recording.file);
      void this.app.carDetails.offerOnce();
    }
  }

  /** End the recording that runs, for another reason than a person's wish. Returns its file; null: none ran, or it could not be ended. */
  async end(): Promise<string | null> {
    const file = this.app.live.state?.recording?.file;
    if (file === undefined || this.busy) return null;
    this.busy = true;
    const state = await this.app.toasts.attempt(() => this.app.api.stopRecording());
    this.busy = false;
    if (state === undefined) return null;
    this.app.toasts.dismiss(new Set([STARTED]));
    return file;
  }

  /** Announce that a recording has ended and is stored, and offer to open it. */
  announceSaved(file: string): void {
    this.app.toasts.dismiss(new Set([STARTED]));
    this.app.toasts.success(() => t("stopped", { file }), {
      duration: OFFER_MS,
      action: { text: () => t("open"), run: () => void this.app.recordings.show(file) },
    });
  }

  /** Everything is recorded, unless a script has reduced the plan: say so then, and offer to record all. */
  private announceStarted(state: State, file: string): void {
    const supported = supportedNames(this.app.catalog.ofUnit, state);
    const wanted = new Set(state.plan.wanted.map(({ name }) => name));
    const [sampled, all] = [supported.filter((name) => wanted.has(name)).length, supported.length];
    if (sampled === all) return this.app.toasts.success(() => t("startedAll", { file }));
    this.app.toasts.success(() => t("started", { file, sampled, all }), {
      duration: OFFER_MS,
      code: STARTED,
      action: { text: () => t("allValues"), run: () => void this.recordAll() },
    });
  }

  private async recordAll(): Promise<void> {
    if (await this.app.subscriptions.subscribeAll()) this.app.toasts.success(() => t("everythingNow"));
  }
}
