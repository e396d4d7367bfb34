// A definition of lines of text as a person types it: texts, until it is saved.
import { fieldText, parsedNumber } from "../../../lib/i18n";
import type { Channel, InstrumentDefinition, OwnInstrument } from "../../../lib/api/types";

export interface DraftChannel {
  name: string;
  text: string;
  unit: string;
  low: string;
  high: string;
}

export interface Draft {
  name: string;
  text: string;
  baud: string;
  /** A pattern a line. */
  patterns: string;
  decimal: "." | ",";
  stale: string;
  channels: DraftChannel[];
}

const NAMES = /(?<!\\)\{([A-Z][A-Z0-9_]*)\}/g;

/** The names of the values in the patterns, each once. */
export function namesIn(patterns: string): string[] {
  return [...new Set([...patterns.matchAll(NAMES)].map(([, name]) => name ?? ""))];
}

export function draftOf(definition: InstrumentDefinition | null, said: (text: Channel["text"]) => string): Draft {
  return {
    name: definition?.name ?? "",
    text: definition ? said(definition.text) : "",
    baud: String(definition?.baud ?? 9600),
    patterns: definition?.patterns.join("\n") ?? "",
    decimal: definition?.decimal === "," ? "," : ".",
    stale: fieldText(definition?.stale ?? 1),
    channels: (definition?.channels ?? []).map((channel) => ({
      name: channel.name,
      text: said(channel.text),
      unit: channel.unit_key,
      low: channel.range ? fieldText(channel.range[0]) : "",
      high: channel.range ? fieldText(channel.range[1]) : "",
    })),
  };
}

/** The channels to be described: the values of the patterns that the catalog lacks, with what was typed of each. */
export function channelsOf(draft: Draft, isKnown: (name: string) => boolean): DraftChannel[] {
  return namesIn(draft.patterns)
    .filter((name) => !isKnown(name))
    .map((name) => draft.channels.find((channel) => channel.name === name) ?? { name, text: "", unit: "", low: "", high: "" });
}

/** The first text that is no number where one is needed; undefined: there is none. */
export function notNumber(draft: Draft): string | undefined {
  const texts = [draft.baud, draft.stale, ...draft.channels.flatMap(({ low, high }) => [low, high].filter((text) => text.trim() !== ""))];
  return texts.find((text) => !Number.isFinite(parsedNumber(text) ?? NaN));
}

/** As the API takes it. A text typed once stands for both languages. */
export function definitionOf(
  draft: Draft,
  isKnown: (name: string) => boolean,
  before: InstrumentDefinition | null,
  said: (text: Channel["text"]) => string,
): OwnInstrument {
  /** What was not changed keeps its other language. */
  const texts = (text: string, known: Channel["text"] | undefined) =>
    known && said(known) === text ? known : { en: text.trim(), ru: text.trim() };
  return {
    text: texts(draft.text || draft.name, before?.text),
    baud: parsedNumber(draft.baud) ?? 0,
    patterns: draft.patterns.split("\n").filter((line) => line.trim() !== ""),
    decimal: draft.decimal,
    stale: parsedNumber(draft.stale) ?? 0,
    channels: channelsOf(draft, isKnown).map(({ name, text, unit, low, high }) => ({
      name,
      text: texts(text || name, before?.channels.find((each) => each.name === name)?.text),
      unit: unit.trim(),
      range: low.trim() === "" || high.trim() === "" ? null : [parsedNumber(low) ?? 0, parsedNumber(high) ?? 0],
    })),
  };
}
