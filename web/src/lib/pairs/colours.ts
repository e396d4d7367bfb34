// Colours of values: a ramp for each theme, whose lightness changes in one direction, so that it also reads without colour vision.

type Rgb = readonly [number, number, number];

/** From low to high. By night the high end is the brightest, by day the darkest: both stand out from the ground. */
const STOPS: Record<"night" | "day", readonly Rgb[]> = {
  night: [
    [88, 92, 214],
    [48, 150, 200],
    [58, 196, 140],
    [190, 214, 70],
    [255, 240, 170],
  ],
  day: [
    [214, 140, 20],
    [204, 84, 12],
    [170, 40, 90],
    [104, 28, 140],
    [28, 18, 84],
  ],
};
const STEPS = 256;

export function colourAt(tone: "night" | "day", share: number): Rgb {
  const stops = STOPS[tone];
  const at = Math.min(1, Math.max(0, share)) * (stops.length - 1);
  const first = Math.min(stops.length - 2, Math.floor(at));
  const part = at - first;
  const mixed = (channel: 0 | 1 | 2) => Math.round(stops[first]![channel] * (1 - part) + stops[first + 1]![channel] * part);
  return [mixed(0), mixed(1), mixed(2)];
}

export const css = ([red, green, blue]: Rgb): string => `rgb(${red} ${green} ${blue})`;

/** A ramp as pixels, 0xAABBGGRR. */
export function rampOf(tone: "night" | "day"): Uint32Array {
  return Uint32Array.from({ length: STEPS }, (_, index) => packed(colourAt(tone, index / (STEPS - 1))));
}

export const packed = ([red, green, blue]: Rgb): number => ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;

/** A token's colour (#rgb, #rrggbb) as a pixel. */
export function packedHex(hex: string): number {
  const long = hex.length === 4 ? hex.slice(1).replace(/./g, "$&$&") : hex.slice(1);
  const number = parseInt(long, 16);
  return packed([number >> 16, (number >> 8) & 255, number & 255]);
}
