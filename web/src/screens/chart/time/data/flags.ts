// Markers, alarms and gaps as flags on the time line; flags that would overlap are merged into one with a count.
import type { LineEvent, Text } from "../../../../lib/api/types";

export interface Flag {
  time: number;
  /** The time for the cursor: inside a gap, not at its edge. */
  at: number;
  kind: "marker" | "warning" | "danger" | "unit" | "gap";
  /** Of the first one: the marker's label, the alarm's text, the gap's full reason. */
  label: string | Text;
  count: number;
}

export function flagsOf(events: readonly LineEvent[], from: number, to: number, minDistance: number): Flag[] {
  const flags: Flag[] = [];
  for (const event of events) {
    if (event.time < from || event.time > to) continue;
    const flag = flagOf(event);
    if (!flag) continue;
    const before = flags.findLast(({ kind }) => kind === flag.kind);
    if (before && flag.time - before.time < minDistance) before.count += 1;
    else flags.push(flag);
  }
  return flags;
}

function flagOf(event: LineEvent): Flag | null {
  const there = { time: event.time, at: event.time, count: 1 };
  if (event.kind === "marker") return { ...there, kind: "marker", label: event.label };
  if (event.kind === "alarm" && (event.level === "warning" || event.level === "danger"))
    return { ...there, kind: event.level, label: event.text ?? "" };
  if (event.kind === "unit" && event.another) return { ...there, kind: "unit", label: event.model ?? "" };
  return null;
}

export interface GapBand {
  from: number;
  to: number;
  /** The state of the line during the gap: short enough for the band. */
  reason: Text | null;
  /** The full reason, with advice. */
  whole: Text | null;
  /** A gap of the second recording in a comparison. */
  second: boolean;
}

/** Gaps that overlap the window; an open gap lasts until `now`. */
export function gapsOf(events: readonly LineEvent[], from: number, to: number, now: number): GapBand[] {
  const bands: GapBand[] = [];
  for (const event of events) {
    if (event.kind !== "gap") continue;
    const ended = event.ended ?? now;
    if (ended < from || event.began > to) continue;
    const reason = stateDuring(events, event.began, ended) ?? event.reason;
    bands.push({ from: event.began, to: ended, reason, whole: event.reason, second: false });
  }
  return bands;
}

/** Gaps of the second recording, moved to the times of the first. */
export function shiftedBy(bands: readonly GapBand[], lag: number): GapBand[] {
  return bands.map((band) => ({ ...band, from: band.from + lag, to: band.to + lag, second: true }));
}

/** The state of the line in that time: a short text for the band; the reason itself is full advice. */
function stateDuring(events: readonly LineEvent[], from: number, to: number): Text | null {
  const state = events.findLast((event) => event.kind === "state" && event.reason !== null && event.time >= from && event.time <= to);
  return state?.kind === "state" ? state.text : null;
}

/** Gaps as flags, at their start or at the start of the window. */
export function gapFlags(bands: readonly GapBand[], from: number, to: number, minDistance: number): Flag[] {
  const flags: Flag[] = [];
  for (const band of bands) {
    const time = Math.max(band.from, from);
    if (time > to) continue;
    const before = flags[flags.length - 1];
    if (before && time - before.time < minDistance) before.count += 1;
    else flags.push({ time, at: (time + Math.min(band.to, to)) / 2, kind: "gap", label: band.whole ?? "", count: 1 });
  }
  return flags;
}

/** The next gap after a time, or the previous one; wraps around at the ends. */
export function nextGap(bands: readonly GapBand[], time: number, step: 1 | -1): GapBand | undefined {
  const ordered = [...bands].sort((one, other) => one.from + one.to - other.from - other.to);
  const after = (band: GapBand) => (step > 0 ? (band.from + band.to) / 2 > time + 1e-6 : (band.from + band.to) / 2 < time - 1e-6);
  return step > 0 ? (ordered.find(after) ?? ordered[0]) : (ordered.findLast(after) ?? ordered[ordered.length - 1]);
}

/** Wrap words into at most `most` lines that fit; text that does not fit ends with an ellipsis. */
export function wrapText(words: string, fits: (text: string) => boolean, most: number): string[] {
  const lines: string[] = [];
  for (const word of words.split(" ")) {
    const last = lines[lines.length - 1];
    if (last !== undefined && fits(`${last} ${word}`)) lines[lines.length - 1] = `${last} ${word}`;
    else lines.push(word);
  }
  const visible = lines.slice(0, most);
  return visible.map((line, index) => {
    const cut = index === most - 1 && lines.length > most;
    if (fits(cut ? `${line}…` : line)) return cut ? `${line}…` : line;
    let short = line;
    while (short.length > 1 && !fits(`${short}…`)) short = short.slice(0, -1);
    return `${short}…`;
  });
}
