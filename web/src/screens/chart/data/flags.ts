// Markers and alarms as flags on the line of time; those that would lie on each other become one with a count.
import type { LineEvent, Text } from "../../../lib/api/types";

export interface Flag {
  time: number;
  /** Where the cursor goes: into a gap, not to its edge. */
  at: number;
  kind: "marker" | "warning" | "danger" | "unit" | "gap";
  /** Of the first; a marker's own words, the text of the alarm, a gap's whole reason. */
  label: string | Text;
  count: number;
}

export function flagsOf(events: readonly LineEvent[], from: number, to: number, apart: number): Flag[] {
  const flags: Flag[] = [];
  for (const event of events) {
    if (event.time < from || event.time > to) continue;
    const flag = flagOf(event);
    if (!flag) continue;
    const before = flags.findLast(({ kind }) => kind === flag.kind);
    if (before && flag.time - before.time < apart) before.count += 1;
    else flags.push(flag);
  }
  return flags;
}

function flagOf(event: LineEvent): Flag | null {
  const there = { time: event.time, at: event.time, count: 1 };
  if (event.kind === "marker") return { ...there, kind: "marker", label: event.label };
  if (event.kind === "alarm" && (event.level === "warning" || event.level === "danger")) return { ...there, kind: event.level, label: event.text };
  if (event.kind === "unit" && event.another) return { ...there, kind: "unit", label: event.model ?? "" };
  return null;
}

export interface GapBand {
  from: number;
  to: number;
  /** What the line was said to be, to be written in the band. */
  reason: Text;
  /** The reason itself, with what to try. */
  whole: Text;
  /** Of the second recording, with which the first is comparison. */
  second: boolean;
}

/** Gaps that lie in the window; one that goes on lasts until now. */
export function gapsOf(events: readonly LineEvent[], from: number, to: number, now: number): GapBand[] {
  const bands: GapBand[] = [];
  for (const event of events) {
    if (event.kind !== "gap") continue;
    const ended = event.ended ?? now;
    if (ended < from || event.began > to) continue;
    const reason = briefly(events, event.began, ended) ?? event.reason;
    bands.push({ from: event.began, to: ended, reason, whole: event.reason, second: false });
  }
  return bands;
}

/** The second recording's, at the times of the first. */
export function lagging(bands: readonly GapBand[], lag: number): GapBand[] {
  return bands.map((band) => ({ ...band, from: band.from + lag, to: band.to + lag, second: true }));
}

/** What the line was said to be in that time: the reason itself is whole advice, too long to be written in a band. */
function briefly(events: readonly LineEvent[], from: number, to: number): Text | null {
  const said = events.findLast((event) => event.kind === "state" && event.reason !== null && event.time >= from && event.time <= to);
  return said?.kind === "state" ? said.text : null;
}

/** Gaps as flags, so that each can be reached; where it begins, or where the window does. */
export function gapFlags(bands: readonly GapBand[], from: number, to: number, apart: number): Flag[] {
  const flags: Flag[] = [];
  for (const band of bands) {
    const time = Math.max(band.from, from);
    if (time > to) continue;
    const before = flags[flags.length - 1];
    if (before && time - before.time < apart) before.count += 1;
    else flags.push({ time, at: (time + Math.min(band.to, to)) / 2, kind: "gap", label: band.whole, count: 1 });
  }
  return flags;
}

/** The gap that follows this moment, or the one before; past the last one the first again. */
export function nextGap(bands: readonly GapBand[], time: number, step: 1 | -1): GapBand | undefined {
  const ordered = [...bands].sort((one, other) => one.from + one.to - other.from - other.to);
  const after = (band: GapBand) => (step > 0 ? (band.from + band.to) / 2 > time + 1e-6 : (band.from + band.to) / 2 < time - 1e-6);
  return step > 0 ? (ordered.find(after) ?? ordered[0]) : (ordered.findLast(after) ?? ordered[ordered.length - 1]);
}

/** Words in lines that fit; what does not, ends in an ellipsis. */
export function folded(words: string, fits: (text: string) => boolean, most: number): string[] {
  const lines: string[] = [];
  for (const word of words.split(" ")) {
    const last = lines[lines.length - 1];
    if (last !== undefined && fits(`${last} ${word}`)) lines[lines.length - 1] = `${last} ${word}`;
    else lines.push(word);
  }
  const kept = lines.slice(0, most);
  return kept.map((line, index) => {
    const cut = index === most - 1 && lines.length > most;
    if (fits(cut ? `${line}…` : line)) return cut ? `${line}…` : line;
    let short = line;
    while (short.length > 1 && !fits(`${short}…`)) short = short.slice(0, -1);
    return `${short}…`;
  });
}
