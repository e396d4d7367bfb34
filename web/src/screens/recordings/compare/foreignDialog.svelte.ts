// What is known and chosen of another program's log before it is read. What the file leaves open stays open here until a person chooses.
import type { ApiClient } from "../../../lib/api/api";
import { ApiRequest } from "../../../lib/api/request.svelte";
import type { ForeignPreview } from "../../../lib/api/types";
import { foreignLog, type ForeignLog } from "../../../lib/recording/foreign";

/** How a text is read; null: as recognised. */
export interface TextSettings {
  encoding: string | null;
  delimiter: string | null;
  decimal: string | null;
  names_line: number | null;
  units_line: number | null;
}

const RECOGNISED: TextSettings = { encoding: null, delimiter: null, decimal: null, names_line: null, units_line: null };
/** The longest file that the program reads. */
export const MOST_BYTES = 64 * 2 ** 20;
/** A file with more columns has none chosen beyond these: their lines in a pane would look alike. */
const CHOSEN_AT_FIRST = 6;

export class ForeignDialog {
  readonly preview = new ApiRequest<ForeignPreview>();
  readonly reading = new ApiRequest<ForeignLog>();
  settings = $state.raw(RECOGNISED);
  /** The place of the time; null: not chosen. */
  time = $state<number | null>(null);
  timeUnit = $state<string | null>(null);
  /** Places of the columns to take. */
  taken = $state.raw<ReadonlySet<number>>(new Set());
  /** By the column's place: another unit than the file's. */
  units = $state<Record<number, string>>({});

  readonly found = $derived(this.preview.value);
  readonly layout = $derived(this.found?.layout ?? null);
  readonly columns = $derived((this.found?.columns ?? []).map((column, place) => ({ ...column, place })));
  /** Those that can be taken: all but the time. */
  readonly offered = $derived(this.columns.filter(({ place }) => this.layout === null || place !== this.time));
  readonly chosen = $derived(this.offered.filter(({ place }) => this.taken.has(place)));
  readonly ready = $derived(
    this.found !== null && this.chosen.length > 0 && (this.layout === null || (this.time !== null && this.timeUnit !== null)),
  );

  readonly tooLarge: boolean;
  /** By its name no text, so how a text is read is no matter. */
  readonly binary: boolean;

  constructor(
    private readonly api: Pick<ApiClient, "foreignPreview" | "foreignValues">,
    readonly file: File,
  ) {
    this.tooLarge = file.size > MOST_BYTES;
    this.binary = /\.(mlg|mf4|mdf)$/i.test(file.name);
  }

  /** Look at the file, and begin with what it says itself. */
  async look(): Promise<void> {
    const found = await this.preview.run(() => this.api.foreignPreview(this.file, { ...this.settings }));
    if (!found) return;
    this.time = found.layout?.time ?? null;
    this.timeUnit = found.layout?.time_unit ?? null;
    this.units = {};
    const numbers = found.columns.map((_, place) => place).filter((place) => place !== this.time && mayBeNumbers(found, place));
    this.taken = new Set(numbers.slice(0, CHOSEN_AT_FIRST));
  }

  /** Read the text otherwise. */
  async set(change: Partial<TextSettings>): Promise<void> {
    this.settings = { ...this.settings, ...change };
    await this.look();
  }

  /** Another column is the time: its unit has to be said, unless the file says it. */
  chooseTime(place: number | null): void {
    this.time = place;
    this.timeUnit = place !== null && place === this.layout?.time ? this.layout.time_unit : null;
  }

  toggle(place: number): void {
    const next = new Set(this.taken);
    if (!next.delete(place)) next.add(place);
    this.taken = next;
  }

  toggleAll(): void {
    this.taken = new Set(this.chosen.length === this.offered.length ? [] : this.offered.map(({ place }) => place));
  }

  /** Read what was chosen. Undefined if it can't be read: `reading.error` says why. */
  read(): Promise<ForeignLog | undefined> {
    return this.reading.run(async () => {
      const places = this.chosen.map(({ place }) => place);
      const values = await this.api.foreignValues(this.file, {
        ...this.settings,
        time: this.layout === null ? null : this.time,
        time_unit: this.layout === null ? null : this.timeUnit,
        columns: places.join(","),
      });
      return foreignLog(
        this.file,
        values,
        places.map((place) => this.units[place]?.trim() ?? null),
      );
    });
  }
}

/** Whether a column has something that looks like a number; a binary log has nothing else. */
function mayBeNumbers({ columns, layout }: ForeignPreview, place: number): boolean {
  const { samples } = columns[place]!;
  return layout === null || samples.every((cell) => cell === "" || /^[-+]?[\d.,]/.test(cell));
}
