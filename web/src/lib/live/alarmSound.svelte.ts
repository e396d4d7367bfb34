// Alarms as sound: off until switched on here, then stored in this browser. A warning is two low tones every 6 s, a danger four high ones every
// 2 s, until no channel is beyond a limit or the sound is switched off. Any page may sound, one that only views as well: a phone beside the
// engine is where it is needed. Browsers play nothing before the first click or key on a page; `waiting` says so.
import { untrack } from "svelte";
import { dictionary } from "../i18n";
import { loadSetting, saveSetting } from "../platform/storage";
import type { Level } from "../api/types";
import type { Live } from "./live.svelte";

interface Pattern {
  /** Hz of each tone, seconds of a tone, seconds between repetitions. */
  tones: number[];
  length: number;
  every: number;
}

const PATTERNS: Record<Level, Pattern> = {
  warning: { tones: [523, 523], length: 0.22, every: 6 },
  danger: { tones: [1047, 784, 1047, 784], length: 0.14, every: 2 },
};

const t = dictionary({ key: { en: "Alarm sound on and off", ru: "Включить и выключить звук тревог" } });

export class AlarmSound {
  on = $state(loadSetting("alarm-sound") === "on");
  /** Switched on, but the browser waits for a click or a key. */
  waiting = $state(false);
  /** The worst alarm now; null: none, or the line's state is not known. */
  readonly worst = $derived.by<Level | null>(() => {
    const alarms = this.live.link === "open" ? (this.live.state?.alarms ?? []) : [];
    if (alarms.some(({ level }) => level === "danger")) return "danger";
    return alarms.length > 0 ? "warning" : null;
  });
  /** Switched off by a person, as it is not from the beginning. */
  get silenced(): boolean {
    return loadSetting("alarm-sound") === "off";
  }

  readonly keyText = (): string => t("key");
  private context: AudioContext | null = null;

  constructor(private readonly live: Live) {}

  toggle(): void {
    this.on = !this.on;
    saveSetting("alarm-sound", this.on ? "on" : "off");
    // Proof that it can be heard.
    if (this.on) void this.start().then(() => this.worst === null && this.play({ tones: [784], length: 0.1, every: 0 }));
  }

  /** For the frame's effect: sound while there is an alarm. Returns what ends it. */
  watch(): (() => void) | undefined {
    if (!this.on) return undefined;
    untrack(() => void this.start());
    // Again when the browser has allowed it.
    void this.waiting;
    const resume = () => void this.start();
    window.addEventListener("pointerup", resume, true);
    window.addEventListener("keydown", resume, true);
    const pattern = this.worst && PATTERNS[this.worst];
    let timer: ReturnType<typeof setInterval> | undefined;
    if (pattern) {
      this.play(pattern);
      timer = setInterval(() => this.play(pattern), pattern.every * 1000);
    }
    return () => {
      clearInterval(timer);
      window.removeEventListener("pointerup", resume, true);
      window.removeEventListener("keydown", resume, true);
    };
  }

  /** A short sound of its own, for what is no alarm; silent until the browser has allowed sound. */
  async chime(): Promise<void> {
    await this.start();
    this.play({ tones: [880, 1175], length: 0.15, every: 0 });
  }

  private async start(): Promise<void> {
    // A context made before the first click or key would be refused, with a complaint in the browser's log.
    if (!this.context && navigator.userActivation?.hasBeenActive === false) {
      this.waiting = true;
      return;
    }
    this.context ??= new AudioContext();
    const context = this.context;
    context.onstatechange = () => (this.waiting = context.state !== "running");
    this.waiting = context.state !== "running";
    if (this.waiting) await context.resume();
  }

  private play({ tones, length }: Pattern): void {
    const context = this.context;
    // A tone that is begun before the first click would be heard late.
    if (context?.state !== "running") return;
    tones.forEach((frequency, index) => {
      const begin = context.currentTime + 0.02 + index * (length + 0.08);
      const tone = context.createOscillator();
      const volume = context.createGain();
      tone.type = "square";
      tone.frequency.value = frequency;
      // Without a click at either end.
      volume.gain.setValueAtTime(0, begin);
      volume.gain.linearRampToValueAtTime(0.25, begin + 0.01);
      volume.gain.setValueAtTime(0.25, begin + length - 0.02);
      volume.gain.linearRampToValueAtTime(0, begin + length);
      tone.connect(volume).connect(context.destination);
      tone.start(begin);
      tone.stop(begin + length);
    });
  }
}
