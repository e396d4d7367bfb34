// A second recording beside the one being played, on a common clock: seconds from the start of each, moved by an offset. It is drawn at the
// first one's times: its own time plus `lag`.
import { frameClock } from "../platform/frameClock.svelte";
import { dictionary, localized } from "../i18n";
import type { Text } from "../api/types";
import type { ForeignLog } from "./foreign";
import { RecordingData } from "./recordingData.svelte";

const t = dictionary({
  virtual: { en: "virtual car, not measured on a real engine", ru: "виртуальный автомобиль, не измерено на настоящем двигателе" },
});

/** Aligning: first a moment on the dashed line is selected, then the same moment on the solid line. */
export type Aligning = { step: "second" } | { step: "first"; at: number } | null;

export class Comparison extends RecordingData {
  /** Seconds by which the second recording is moved to the right. */
  offset = $state(0);
  aligning = $state.raw<Aligning>(null);
  /** Called when a comparison begins. */
  onshown: () => void = () => undefined;
  /** Called when another program's log begins or ends (null). */
  onforeign: (log: ForeignLog | null) => void = () => undefined;
  private foreign = $state.raw<ForeignLog | null>(null);
  /** What of another program's log was not taken. */
  readonly remarks = $derived(this.foreign?.remarks ?? []);
  private zero = $state(0);

  readonly active = $derived(this.detail !== null);
  /** The name of a recording of the virtual car, whose id is none. */
  private named = $state.raw<Text | null>(null);
  /** The second recording's name for a person; of the virtual car: with these words. */
  readonly title = $derived(
    [localized(this.named) || (this.detail?.id ?? ""), this.detail?.virtual ? `(${t("virtual")})` : ""].filter(Boolean).join(" "),
  );
  readonly lag = $derived(this.zero - this.first + this.offset);

  /** Load a recording to compare with the one that starts at `zero`; `named`: its name, if not its id. Throws `ApiError`. */
  async start(id: string, zero: number, named: Text | null = null): Promise<boolean> {
    this.end();
    this.named = named;
    this.zero = zero;
    if (!(await this.load(id))) return false;
    this.onshown();
    frameClock.request();
    return true;
  }

  /** Another program's log in place of a recording. */
  startForeign(log: ForeignLog, zero: number): void {
    this.end();
    this.named = null;
    this.zero = zero;
    this.adopt(log.detail, log.columns);
    this.foreign = log;
    this.onforeign(log);
    this.onshown();
    frameClock.request();
  }

  /** Nothing is decoded otherwise in another program's log. */
  override async reload(): Promise<void> {
    if (this.foreign === null) await super.reload();
  }

  end(): void {
    this.reset();
    if (this.foreign !== null) {
      this.foreign = null;
      this.onforeign(null);
    }
    this.offset = 0;
    this.aligning = null;
  }

  shift(seconds: number): void {
    this.moveTo(this.offset + seconds);
  }

  moveTo(offset: number): void {
    // Rounded to milliseconds, so that repeated steps of 0.1 do not accumulate errors.
    this.offset = Math.round(offset * 1000) / 1000;
    frameClock.request();
  }

  /** Start or cancel aligning. */
  toggleAligning(): void {
    this.aligning = this.aligning ? null : { step: "second" };
  }

  /** Use a selected moment: first on the dashed line, then on the solid one. */
  alignAt(time: number): void {
    if (!this.aligning) return;
    if (this.aligning.step === "second") {
      this.aligning = { step: "first", at: time };
      return;
    }
    this.shift(time - this.aligning.at);
    this.aligning = null;
  }
}
