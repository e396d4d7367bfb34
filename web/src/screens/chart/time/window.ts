// The window of time that the chart shows: its length, and where it stays when that changes.

export interface Window {
  from: number;
  to: number;
}

/** Seconds. */
export const SHORTEST = 0.2;
export const LONGEST = 12 * 3600;

/** The window of that length that ends there, moved into the bounds; if it is longer than they are: all of them. */
export function within(to: number, span: number, bounds: Window | null): Window {
  const length = Math.min(LONGEST, Math.max(SHORTEST, span));
  if (!bounds) return { from: to - length, to };
  const most = Math.max(SHORTEST, bounds.to - bounds.from);
  if (length >= most) return { from: bounds.from, to: bounds.from + most };
  const end = Math.min(bounds.to, Math.max(bounds.from + length, to));
  return { from: end - length, to: end };
}

/** Another length around a time that keeps its place. */
export function zoomed({ from, to }: Window, span: number, around: number, bounds: Window | null): Window {
  const length = Math.min(LONGEST, Math.max(SHORTEST, span));
  return within(around + ((to - around) / (to - from)) * length, length, bounds);
}

/**
 * Another length in which `anchor` keeps its place, or is in the middle if it was outside; `also` is inside as well, if both have room.
 */
export function around(window: Window, span: number, anchor: number, also: number | null, bounds: Window | null): Window {
  const inside = anchor >= window.from && anchor <= window.to;
  const found = inside ? zoomed(window, span, anchor, bounds) : within(anchor + span / 2, span, bounds);
  if (also === null || Math.abs(also - anchor) > span) return found;
  return within(Math.min(also + span, Math.max(also, found.to)), span, bounds);
}
