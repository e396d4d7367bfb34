// Markers and alarms as flags on the line of time; those that would lie on each other become one with a count.
import type { LineEvent, Text } from "../../lib/types";

export interface Flag {
  time: number;
  kind: "marker" | "warning" | "danger" | "unit";
  /** Of the first; a marker's own words, or the text of the alarm. */
  label: string | Text;
  count: number;
}

export function flagsOf(events: readonly LineEvent[], from: number, to: number, apart: number): Flag[] {
  const flags: Flag[] = [];
  for (const event of events) {
    if (event.time < from || event.time > to) continue;
    const flag = flagOf(event);
    if (!flag) continue;
    const before = flags[flags.length - 1];
    if (before && before.kind === flag.kind && flag.time - before.time < apart) before.count += 1;
    else flags.push(flag);
  }
  return flags;
}

function flagOf(event: LineEvent): Flag | null {
  if (event.kind === "marker") return { time: event.time, kind: "marker", label: event.label, count: 1 };
  if (event.kind === "alarm" && (event.level === "warning" || event.level === "danger")) {
    return { time: event.time, kind: event.level, label: event.text, count: 1 };
  }
  if (event.kind === "unit" && event.another) return { time: event.time, kind: "unit", label: event.model ?? "", count: 1 };
  return null;
}

export interface GapBand {
  from: number;
  to: number;
  reason: Text;
}

/** Gaps that lie in the window; one that goes on lasts until now. */
export function gapsOf(events: readonly LineEvent[], from: number, to: number, now: number): GapBand[] {
  const bands: GapBand[] = [];
  for (const event of events) {
    if (event.kind !== "gap") continue;
    const ended = event.ended ?? now;
    if (ended < from || event.began > to) continue;
    bands.push({ from: event.began, to: ended, reason: briefly(events, event.began, ended) ?? event.reason });
  }
  return bands;
}

/** What the line was said to be in that time: the reason itself is whole advice, too long to be written in a band. */
function briefly(events: readonly LineEvent[], from: number, to: number): Text | null {
  const said = events.findLast((event) => event.kind === "state" && event.reason !== null && event.time >= from && event.time <= to);
  return said?.kind === "state" ? said.text : null;
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
