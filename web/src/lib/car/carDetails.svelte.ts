// Car, plate, mileage and workshop: of the connected unit, or of a recording. Asked once for a unit, at its first recording or report.
import type { Car, Recording } from "../api/types";
import { dictionary } from "../i18n";
import type { Stores } from "../../stores";

const t = dictionary({
  ask: {
    en: "Whose car is this? Car, plate and mileage stand in the list and on the report.",
    ru: "Чья это машина? Марка, номер и пробег будут в списке и в отчёте.",
  },
  add: { en: "Add car details…", ru: "Указать машину…" },
});

/** What is edited: a recording, or the connected unit (null). `offered`: the last mileage, shown as an example. */
export interface CarEdit {
  recording: string | null;
  details: Car;
  offered: number | null;
  /** The user did not ask for it. */
  asked?: boolean;
  onsaved?: () => void;
}

export class CarDetails {
  editing = $state.raw<CarEdit | null>(null);

  constructor(private readonly app: Pick<Stores, "api" | "live" | "player" | "toasts">) {}

  /** Edit the car of the connected unit. */
  async editConnected(onsaved?: () => void): Promise<void> {
    const kept = await this.app.toasts.attempt(() => this.app.api.car());
    if (kept) this.editing = { recording: null, details: offeredOf(kept), offered: kept.mileage, onsaved };
  }

  /** Edit the car of a recording; the program keeps it for the connected unit too, if that is recorded and has none. */
  edit(recording: Recording, onsaved?: () => void): void {
    this.editing = { recording: recording.id, details: recording.car, offered: null, onsaved };
  }

  async save(details: Car): Promise<void> {
    const edit = this.editing;
    if (!edit) return;
    const { recording } = edit;
    const saved = await this.app.toasts.attempt(() => this.app.api.writeCar(recording, details));
    if (!saved) return;
    if (recording !== null) this.app.player.described(recording, saved);
    edit.onsaved?.();
    this.editing = null;
  }

  close(): void {
    this.editing = null;
  }

  /** Ask once about the connected unit, at its first report; "Later" puts it off for good. */
  async askOnce(onsaved: () => void): Promise<void> {
    const kept = await this.firstTime();
    if (!kept) return;
    if (document.querySelector("dialog[open]")) return this.offer(); // what the user opened meanwhile
    this.editing = { recording: null, details: offeredOf(kept), offered: kept.mileage, asked: true, onsaved };
  }

  /** The same at its first recording, beside the screen: what is measured has to be seen, and the next key may set a marker. */
  async offerOnce(): Promise<void> {
    if (await this.firstTime()) this.offer();
  }

  private offer(): void {
    this.app.toasts.success(() => t("ask"), {
      duration: 20_000,
      code: "CarDetails",
      action: { text: () => t("add"), run: () => void this.editConnected() },
    });
  }

  /** What is kept of the connected unit's car if it was not asked about before; from now on it was. A virtual car has no plate. */
  private async firstTime() {
    if (this.app.live.state?.port?.startsWith("sim:")) return null;
    const kept = await this.app.api.car().catch(() => null);
    if (!kept?.unit || kept.asked) return null;
    await this.app.api.writeCar(null, offeredOf(kept)).catch(() => null);
    return kept;
  }
}

/** What of a kept car is still so at the next recording. */
const offeredOf = ({ car, plate, workshop }: Car): Car => ({ car, plate, workshop, mileage: null });
