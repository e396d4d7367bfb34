// The actions on conditions on this page: their sheet, their sound and voice. Each page that is open sounds and speaks, unless that is switched off here; a browser plays nothing
// before the first click or key on a page.
import { language, localized } from "../i18n";
import { loadSetting, saveSetting } from "../platform/storage";
import type { Text } from "../api/types";
import type { AlarmSound } from "./alarmSound.svelte";

const SPOKEN = { en: "en-GB", ru: "ru-RU" } as const;

export class PageActions {
  /** Whether the sheet of the actions is open. */
  open = $state(false);
  on = $state(loadSetting("action-voice") !== "off");
  /** This browser can speak. */
  readonly speaks = "speechSynthesis" in globalThis;

  constructor(private readonly alarmSound: AlarmSound) {}

  toggle(): void {
    this.on = !this.on;
    saveSetting("action-voice", this.on ? "on" : "off");
    if (!this.on && this.speaks) speechSynthesis.cancel();
  }

  ring(): void {
    if (this.on) void this.alarmSound.chime();
  }

  say(text: Text): void {
    if (!this.on || !this.speaks) return;
    const words = new SpeechSynthesisUtterance(localized(text));
    words.lang = SPOKEN[language.code];
    // What was to be said before is old news by now.
    speechSynthesis.cancel();
    speechSynthesis.speak(words);
  }
}
