// How wide a text is, so that digits can be as large as their tile allows and stay at that size while the value changes.
import { number } from "../i18n";
import type { Channel } from "../api/types";

const SIZE = 100;
const known = new Map<string, number>();
let pen: CanvasRenderingContext2D | null | undefined;

/** The width of a text in em, in the page's font at this weight. */
export function emWidth(text: string, weight = 650): number {
  const key = `${weight} ${text}`;
  let width = known.get(key);
  if (width === undefined) {
    pen ??= document.createElement("canvas").getContext("2d");
    const font = getComputedStyle(document.documentElement).fontFamily;
    if (pen) pen.font = `${weight} ${SIZE}px ${font}`;
    width = pen ? pen.measureText(text).width / SIZE : 0.65 * text.length;
    if (known.size > 500) known.clear();
    known.set(key, width);
  }
  return width;
}

/** Every digit as a zero: all digits are equally wide. */
const asZeros = (text: string): string => text.replace(/\d/g, "0");

/** The widest text a channel shows in em: of its scale, or of its two words; wider only for a value beyond that. */
export function widestText(channel: Channel | undefined, words: readonly string[], now: string): number {
  const ends = channel?.gauge ?? channel?.range ?? [0, 100];
  const texts = words.length > 0 ? words : ends.map((end) => asZeros(number(end, channel?.decimals ?? 0)));
  return Math.max(...[...texts, asZeros(now)].map((text) => emWidth(text)));
}
