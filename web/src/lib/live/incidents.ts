// What the list of errors shows, newest first: an incident is a gap with the errors that caused it, or an error without a gap. The server
// sends both: the gap's reason is the text of the error that began it, so shown one by one each fault of the line would stand there twice.
import { spaced } from "../i18n";
import type { LineEvent } from "../api/types";

type Gap = LineEvent & { kind: "gap" };
type Failure = LineEvent & { kind: "error" };
/** What is shown besides gaps and errors: another port, another date of the computer. */
type Moved = LineEvent & { kind: "adapter" | "clock" };

/** An error as it is shown: `text` and `bytes` false if the gap's reason has them already. */
export interface Shown {
  error: Failure;
  text: boolean;
  bytes: boolean;
}

export interface Incident {
  /** When it began. */
  time: number;
  gap: Gap | null;
  moved: Moved | null;
  /** All errors that belong to it. */
  count: number;
  errors: Shown[];
}

const MOST = 100;

export function incidents(events: readonly LineEvent[]): Incident[] {
  const found = events.flatMap((event): Incident[] => {
    if (event.kind === "gap") return [{ time: event.began, gap: event, moved: null, count: 0, errors: [] }];
    const moved = event.kind === "adapter" || event.kind === "clock" ? event : null;
    return moved ? [{ time: moved.time, gap: null, moved, count: 0, errors: [] }] : [];
  });
  const gaps = found.filter(({ gap }) => gap);
  for (const event of events) {
    if (event.kind !== "error") continue;
    const within = gaps.find(({ gap }) => gap!.began <= event.time && event.time <= (gap!.ended ?? Infinity));
    const shown = shownIn(event, within?.gap ?? null);
    if (!within) found.push({ time: event.time, gap: null, moved: null, count: 1, errors: [shown] });
    else {
      within.count += 1;
      if (shown.text || shown.bytes) within.errors.push(shown);
    }
  }
  return found.sort((a, b) => b.time - a.time).slice(0, MOST);
}

function shownIn(error: Failure, gap: Gap | null): Shown {
  const sent = error.sent ? spaced(error.sent) : "";
  const received = error.received ? spaced(error.received) : "";
  if (!gap) return { error, text: true, bytes: Boolean(sent || received) };
  const { en, ru } = gap.reason ?? { en: "", ru: "" };
  const has = (words: string) => en.includes(words) && ru.includes(words);
  return {
    error,
    text: !(en.includes(error.text.en) && ru.includes(error.text.ru)),
    bytes: Boolean(sent || received) && !(has(sent) && has(received)),
  };
}
