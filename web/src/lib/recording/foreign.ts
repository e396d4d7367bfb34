// Another program's log as the second recording of a comparison. Its columns keep their names and units: in the chart they are channels whose
// names begin with `log:`, so that none can be taken for one of ours.
import type { Channel, ForeignValues, RecordingDetail, Text } from "../api/types";
import { Columns } from "../series/columns";

const PREFIX = "log:";
/** More decimals than these no instrument measures. */
const MOST_DECIMALS = 4;
/** Values that are looked at for the decimals. */
const LOOKED_AT = 500;

/** Whether the name of a channel is that of another program's log. */
export const isForeign = (name: string): boolean => name.startsWith(PREFIX);

/** The name in the chart of a column of another program's log. */
export const foreignName = (name: string): string => PREFIX + name;

export interface ForeignLog {
  channels: readonly Channel[];
  detail: RecordingDetail;
  columns: Columns;
  /** What of the file was not taken. */
  remarks: readonly Text[];
}

const same = (text: string): Text => ({ en: text, ru: text });

/** The values that the program has read, with the units that the user gave; null: the file's. */
export function foreignLog(
  file: Pick<File, "name" | "size">,
  values: ForeignValues,
  units: readonly (string | null)[] | null = null,
): ForeignLog {
  const channels = values.names.map((name, at) => channelOf(name, units?.[at] ?? values.units[at]!, values.values[at]!));
  const columns = new Columns(values.times.length + 16);
  columns.append(
    channels.map(({ name }) => name),
    values.times,
    values.values,
  );
  const [first, last] = [columns.first, columns.last];
  const length = last - first;
  if (values.decimated) columns.spacing = (4 * length) / Math.max(1, columns.length);
  const detail: RecordingDetail = {
    id: file.name,
    bytes: file.size,
    date: values.started,
    length,
    model: null,
    passport: null,
    samples: values.rows,
    samples_exact: true,
    rate: length > 0 ? values.rows / length : null,
    gaps: 0,
    faults: null,
    markers: values.marks.length,
    note: "",
    car: { car: "", plate: "", mileage: null, workshop: "" },
    open: false,
    reference: false,
    virtual: false,
    clock: [],
    problem: null,
    channels: channels.map(({ name }) => name),
    instruments: [],
    absent: [],
    first,
    last,
    events: values.marks.map(({ time, text }) => ({ kind: "marker", time, label: text })),
    problems: [],
    method: null,
  };
  return { channels, detail, columns, remarks: values.problems };
}

/** What the chart has to know of a column; no limits, no reference, nothing of ours. */
function channelOf(name: string, unit: string, values: readonly (number | null)[]): Channel {
  return {
    name: foreignName(name),
    derived: false,
    flag: false,
    code: null,
    size: null,
    unit: same(unit),
    unit_key: unit,
    text: same(name),
    short: same(name),
    names: [],
    decimals: decimalsOf(values),
    formula: "",
    range: null,
    reference: null,
    gauge: null,
    span_least: null,
    limits: null,
    lamp: null,
    alarm_when_true: "none",
    inputs: null,
    errata: [],
    otherwise: [],
    confidence: "unconfirmed",
    source: "",
    evidence: null,
    reference_confidence: "unconfirmed",
    range_kind: "",
    meaning: null,
    constants: {},
    accumulates: false,
    instrument: false,
    own: [],
    mine: false,
    writable: false,
  };
}

/** The decimals that the numbers have in the file. */
export function decimalsOf(values: readonly (number | null)[]): number {
  let most = 0;
  for (const value of values.slice(0, LOOKED_AT)) {
    if (value === null) continue;
    const [, decimals = ""] = value.toFixed(MOST_DECIMALS).replace(/0+$/, "").split(".");
    most = Math.max(most, decimals.length);
  }
  return most;
}
