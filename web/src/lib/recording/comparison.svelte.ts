// A second recording beside the one that is played, on the same clock: seconds from each one's beginning, moved by an offset. It is drawn at
// the first one's times: its own time and the lag.
import { frameClock } from "../view/frameClock.svelte";
import { RecordingData } from "./recordingData.svelte";

/** A moment of the dashed line is being chosen, then the same moment of the solid one. */
export type Aligning = { step: "second" } | { step: "first"; at: number } | null;

class Comparison extends RecordingData {
  /** Seconds; later than its own beginning would have it: more. */
  offset = $state(0);
  aligning = $state.raw<Aligning>(null);
  private zero = $state(0);

  readonly active = $derived(this.detail !== null);
  readonly lag = $derived(this.zero - this.first + this.offset);

  /** Beside the recording that begins at `zero`. Throws `ApiError`. */
  async start(id: string, zero: number): Promise<boolean> {
    this.end();
    this.zero = zero;
    if (!(await this.load(id))) return false;
    frameClock.request();
    return true;
  }

  end(): void {
    this.reset();
    this.offset = 0;
    this.aligning = null;
  }

  shift(seconds: number): void {
    this.moveTo(this.offset + seconds);
  }

  moveTo(offset: number): void {
    // To the millisecond: tenths added up stay tenths.
    this.offset = Math.round(offset * 1000) / 1000;
    frameClock.request();
  }

  /** Begins to align, or lets it be. */
  toggleAligning(): void {
    this.aligning = this.aligning ? null : { step: "second" };
  }

  /** A moment on the screen was chosen: first where the dashed line has it, then where the solid one has the same. */
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

export const comparison = new Comparison();
