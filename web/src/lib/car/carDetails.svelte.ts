// Car, plate, mileage and workshop: of the connected unit, or of a recording. Asked once for a unit, at its first recording or report.
import { api } from "../api/api";
import type { Car, Recording } from "../api/types";
import { live } from "../live/live.svelte";
import { attempt } from "../frame/toasts.svelte";

export const NO_CAR: Car = { car: "", plate: "", mileage: null, workshop: "" };

/** What is edited: a recording, or the connected unit (null). `offered`: the last mileage, shown as an example. */
export interface CarEdit {
  recording: string | null;
  details: Car;
  offered: number | null;
  /** The user did not ask for it. */
  asked?: boolean;
  onsaved?: (details: Car) => void;
}

class CarDetails {
  editing = $state.raw<CarEdit | null>(null);

  /** Edit the car of the connected unit. */
  async editConnected(onsaved?: (details: Car) => void): Promise<void> {
    const kept = await attempt(() => api.car());
    if (!kept) return;
    const { car, plate, workshop } = kept;
    this.editing = { recording: null, details: { car, plate, workshop, mileage: null }, offered: kept.mileage, onsaved };
  }

  /** Edit the car of a recording; an empty one starts from the connected unit's, if that has the same passport. */
  edit(recording: Recording, onsaved?: (details: Car) => void): void {
    this.editing = { recording: recording.id, details: recording.car, offered: null, onsaved };
  }

  async save(details: Car): Promise<boolean> {
    const edit = this.editing;
    if (!edit) return false;
    const saved = await attempt(() =>
      edit.recording === null ? api.writeCar(details) : api.writeRecordingCar(edit.recording, details),
    );
    if (!saved) return false;
    edit.onsaved?.(details);
    this.editing = null;
    return true;
  }

  close(): void {
    this.editing = null;
  }

  /** Ask once about the connected unit, at its first recording or report; "Later" puts it off for good. A virtual car has no plate. */
  async askOnce(onsaved?: (details: Car) => void): Promise<void> {
    if (live.state?.port?.startsWith("sim:")) return;
    const kept = await api.car().catch(() => null);
    if (!kept?.unit || kept.asked) return;
    const { car, plate, workshop } = kept;
    await api.writeCar({ car, plate, workshop, mileage: null }).catch(() => null);
    this.editing = { recording: null, details: { car, plate, workshop, mileage: null }, offered: kept.mileage, asked: true, onsaved };
  }
}

export const carDetails = new CarDetails();
