// What a screen's data are of: the connected car, or the recordings in the screen's address.

/** In the screen's address: the connected car. No recording has this name. */
export const LIVE = "live";

/**
 * The recording that a screen is of, null for the connected car: the one in its address, or else the open one, so that the screen is of what
 * the other screens show.
 */
export function sourceOf(asked: string | undefined, open: string | null): string | null {
  if (asked === undefined) return open;
  return asked === LIVE ? null : asked;
}
