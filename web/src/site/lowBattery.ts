// A phone feeds the cable by its one socket and is not charged meanwhile. Before it is empty a person is warned, and a recording is closed while there is
// time for it: a phone that switches itself off leaves the file without its last second, and without what is written at its end.
import { dictionary, number } from "../lib/i18n";
import type { Stores } from "../stores";

const t = dictionary({
  low: {
    en: "Battery at {percent} %. The phone does not charge while the cable is in it. At 10 % a running recording is closed, so that it is whole.",
    ru: "Заряд {percent} %. Пока в телефон вставлен кабель, он не заряжается. При 10 % запись будет закрыта, чтобы файл остался целым.",
  },
  closed: {
    en: "Battery at {percent} %: the recording {file} was closed in time and is kept. Values still come. Charge the phone before you record again.",
    ru: "Заряд {percent} %: запись {file} закрыта вовремя и сохранена. Опрос продолжается. Перед новой записью зарядите телефон.",
  },
});

/** Percent: when a person is warned; when a recording is closed; above which both may come again. */
const LOW = 20;
const LAST = 10;
const AGAIN = 5;

const CODES = { low: "BatteryLow", closed: "BatteryClosed" };

export class LowBattery {
  private warned = false;
  private closed = false;

  constructor(private readonly app: Pick<Stores, "live" | "recordingControl" | "toasts">) {}

  /** Called with each state. `left`: percent while the phone feeds a cable and is not charged, or null. */
  async follow(left: number | null): Promise<void> {
    const { live, recordingControl, toasts } = this.app;
    if (left === null) return this.warned ? toasts.dismiss(new Set([CODES.low])) : undefined;
    if (left > LOW + AGAIN) this.warned = false;
    if (left > LAST + AGAIN) this.closed = false;
    if (left <= LAST && !this.closed) {
      this.closed = true; // who begins to record after that knows what they do
      if (live.state?.recording) {
        const file = await recordingControl.end();
        if (file === null) return void (this.closed = false);
        this.warned = true;
        toasts.dismiss(new Set([CODES.low]));
        return toasts.refuse(() => t("closed", { percent: number(left), file }), { code: CODES.closed, duration: Infinity });
      }
    }
    if (left > LOW || this.warned) return;
    this.warned = true;
    toasts.refuse(() => t("low", { percent: number(left) }), { code: CODES.low, duration: Infinity });
  }
}
