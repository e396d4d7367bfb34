// Completion of a formula while it is typed: channels, constants, functions and words that begin with, or contain, what stands before the caret, also in another name.

export interface Candidate {
  /** What is inserted. */
  name: string;
  /** What it is, in words. */
  about: string;
  /** Other names, which formulas understand as well: words joined by “_”. */
  also?: readonly string[];
  kind: "channel" | "constant" | "function" | "word";
}

export interface Completion extends Candidate {
  /** The part of the formula that it replaces. */
  from: number;
  to: number;
}

const MOST = 8;

/** What may stand at the caret; empty without a letter before it. Names that begin so come first; a text is searched as well. */
export function completions(formula: string, caret: number, candidates: readonly Candidate[]): Completion[] {
  const before = /[\p{L}_][\p{L}\d_]*$/u.exec(formula.slice(0, caret))?.[0] ?? "";
  if (!before) return [];
  const after = /^[\p{L}\d_]*/u.exec(formula.slice(caret))![0];
  const typed = before.toLocaleLowerCase().replaceAll("ё", "е");
  const rank = ({ name, about, also = [] }: Candidate): number => {
    const lower = name.toLocaleLowerCase();
    if (lower === typed && after === "") return -1;
    if (also.includes(typed)) return 4;
    if (lower.startsWith(typed)) return 3;
    if (typed.length > 1 && [lower, ...also].some((each) => each.includes(typed))) return 2;
    return typed.length > 1 && about.toLocaleLowerCase().includes(typed) ? 1 : 0;
  };
  return candidates
    .map((candidate) => ({ candidate, rank: rank(candidate) }))
    .filter(({ rank }) => rank > 0)
    .sort((one, two) => two.rank - one.rank)
    .slice(0, MOST)
    .map(({ candidate }) => ({ ...candidate, from: caret - before.length, to: caret + after.length }));
}

/** Whether a whole name stands before the caret: then nothing should replace it unasked (DET is in RDET). */
export function isWhole(formula: string, caret: number, candidates: readonly Candidate[]): boolean {
  const before = /[\p{L}_][\p{L}\d_]*$/u.exec(formula.slice(0, caret))?.[0].toLocaleLowerCase();
  return candidates.some(({ name, also = [] }) => name.toLocaleLowerCase() === before || also.includes(before ?? ""));
}

/** Whether a key inserts the chosen one of `count` completions; `chosen` −1: none is, and Tab leaves the field. */
export const inserts = ({ key, shiftKey }: Pick<KeyboardEvent, "key" | "shiftKey">, count: number, chosen: number): boolean =>
  count > 0 && chosen >= 0 && (key === "Enter" || (key === "Tab" && !shiftKey));

/** The formula with the completion inserted, and the caret behind it: inside the brackets of a function. */
export function completed(formula: string, { name, kind, from, to }: Completion): { formula: string; caret: number } {
  const rest = formula.slice(to);
  const inserted = kind === "function" && !rest.startsWith("(") ? `${name}()` : name;
  const caret = from + name.length + (kind === "function" ? 1 : 0);
  return { formula: formula.slice(0, from) + inserted + rest, caret };
}
