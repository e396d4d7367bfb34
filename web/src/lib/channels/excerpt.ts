// The part of a formula around its wrong characters, to show beside the problem.

const AROUND = 20;

export interface Excerpt {
  before: string;
  wrong: string;
  after: string;
}

/** Whole words only, with … where something is left out; null: no character is named. */
export function excerpt(formula: string, span: readonly [number, number] | null): Excerpt | null {
  const wrong = span ? formula.slice(...span) : "";
  if (!span || !wrong.trim()) return null;
  const [from, to] = span;
  const before = formula.slice(0, from);
  const after = formula.slice(to);
  // A cut goes on to the end of its word; a leading or trailing rest of a few characters is not worth the sign.
  const first = /\S*$/.exec(before.slice(0, Math.max(0, from - AROUND)))!;
  const last = /^\S*/.exec(after.slice(AROUND))!;
  const begin = first.index;
  const end = AROUND + last[0].length;
  return {
    before: begin > 2 ? `…${before.slice(begin)}` : before,
    wrong,
    after: after.length - end > 2 ? `${after.slice(0, end)}…` : after,
  };
}
