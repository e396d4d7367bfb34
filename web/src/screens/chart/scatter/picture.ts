// Draws the cloud with its axes and the scale of its colours on a canvas, which is also the PNG.
import { paint, type Cloud, type Frame, type Inks } from "../../../lib/pairs/cloud";
import { roundValues } from "../../../lib/pairs/bins";

/** Pixels around the points: for the axes' numbers and titles, and for the colour scale above. */
export const MARGIN = { left: 64, right: 14, top: 40, bottom: 44 };

export interface Look {
  text: string;
  muted: string;
  grid: string;
  ground: string;
  font: string;
}

/** What the colours mean: a channel from low to high, its two states, or the number of readings. */
export interface Scale {
  title: string;
  low: string;
  high: string;
  /** CSS colours from low to high. */
  stops: readonly string[];
}

export interface Picture {
  /** CSS pixels of the canvas. */
  width: number;
  height: number;
  cloud: Cloud;
  second: Cloud | null;
  inks: Inks;
  secondInk: number;
  x: string;
  y: string;
  scale: Scale | null;
  /** A sentence at the right of the scale. */
  remark: string;
  look: Look;
  text: (value: number) => string;
}

/** The plot's size on a canvas of this size. */
export const plotSize = (width: number, height: number): [number, number] => [
  Math.max(1, Math.floor(width - MARGIN.left - MARGIN.right)),
  Math.max(1, Math.floor(height - MARGIN.top - MARGIN.bottom)),
];

/** Zoom a range around one of its places, 0 … 1. */
export function zoomed([low, high]: readonly [number, number], factor: number, at: number): [number, number] {
  const around = low + (high - low) * at;
  return [around - (around - low) * factor, around + (high - around) * factor];
}

export const moved = ([low, high]: readonly [number, number], share: number): [number, number] => [
  low - (high - low) * share,
  high - (high - low) * share,
];

/** Draw everything. `points`: an own canvas for the points, kept between calls. */
export function draw(canvas: HTMLCanvasElement, points: HTMLCanvasElement, picture: Picture, ratio: number): void {
  const { width, height, cloud, look } = picture;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  if (!context) return;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.fillStyle = look.ground;
  context.fillRect(0, 0, width, height);
  context.font = look.font;
  axes(context, picture);
  drawPoints(points, picture);
  context.imageSmoothingEnabled = false;
  context.drawImage(points, MARGIN.left, MARGIN.top, cloud.width, cloud.height);
  scale(context, picture);
}

/** Kept between drawings: megabytes. */
let image: ImageData | null = null;

function drawPoints(points: HTMLCanvasElement, { cloud, second, inks, secondInk }: Picture): void {
  if (points.width !== cloud.width || points.height !== cloud.height) {
    points.width = cloud.width;
    points.height = cloud.height;
  }
  const context = points.getContext("2d", { willReadFrequently: true });
  if (!context) return;
  if (image?.width !== cloud.width || image.height !== cloud.height) image = context.createImageData(cloud.width, cloud.height);
  const pixels = new Uint32Array(image.data.buffer);
  pixels.fill(0);
  if (second) paint(second, pixels, { ...inks, ramp: Uint32Array.of(secondInk), plain: secondInk, density: false });
  paint(cloud, pixels, inks);
  context.putImageData(image, 0, 0);
}

function axes(context: CanvasRenderingContext2D, { cloud, x, y, look, text }: Picture): void {
  const { width, height } = cloud;
  const bottom = MARGIN.top + height;
  const frame: Frame = cloud.frame;
  context.strokeStyle = look.grid;
  context.fillStyle = look.text;
  context.lineWidth = 1;
  context.textBaseline = "top";
  context.textAlign = "center";
  for (const value of roundValues(...frame.x, Math.max(2, Math.floor(width / 80)))) {
    const at = Math.round(MARGIN.left + cloud.place(value, 0)[0]) + 0.5;
    line(context, at, MARGIN.top, at, bottom);
    context.fillText(text(value), at, bottom + 5);
  }
  context.textBaseline = "middle";
  context.textAlign = "right";
  for (const value of roundValues(...frame.y, Math.max(2, Math.floor(height / 46)))) {
    const at = Math.round(MARGIN.top + cloud.place(0, value)[1]) + 0.5;
    line(context, MARGIN.left, at, MARGIN.left + width, at);
    context.fillText(text(value), MARGIN.left - 6, at);
  }
  context.fillStyle = look.muted;
  context.textBaseline = "bottom";
  context.fillText(`${x} →`, MARGIN.left + width, bottom + MARGIN.bottom - 4);
  context.textAlign = "left";
  context.fillText(`${y} ↑`, 4, MARGIN.top - 6);
}

function line(context: CanvasRenderingContext2D, fromX: number, fromY: number, toX: number, toY: number): void {
  context.beginPath();
  context.moveTo(fromX, fromY);
  context.lineTo(toX, toY);
  context.stroke();
}

/** The colour scale: in the upper right corner, with its numbers. */
function scale(context: CanvasRenderingContext2D, { width, scale, remark, look }: Picture): void {
  context.textBaseline = "middle";
  context.textAlign = "right";
  context.fillStyle = look.text;
  let right = width - MARGIN.right;
  if (scale) {
    context.fillText(scale.high, right, 10);
    right -= context.measureText(scale.high).width + 6;
    const wide = scale.stops.length > 2 ? 90 : 28;
    const step = wide / scale.stops.length;
    scale.stops.forEach((colour, at) => {
      context.fillStyle = colour;
      context.fillRect(right - wide + at * step, 4, Math.ceil(step) + (at + 1 < scale.stops.length ? 1 : 0), 12);
    });
    right -= wide + 6;
    context.fillStyle = look.text;
    const low = `${scale.title}: ${scale.low}`;
    context.fillText(low, right, 10);
    right -= context.measureText(low).width + 16;
  }
  context.fillStyle = look.muted;
  context.textAlign = "left";
  if (remark)
    context.fillText(
      shortened(remark, right - 8, (text) => context.measureText(text).width),
      4,
      10,
    );
}

/** The text, or as much of it as is at most `most` wide. */
export function shortened(text: string, most: number, widthOf: (text: string) => number): string {
  if (widthOf(text) <= most) return text;
  let length = text.length;
  while (length > 0 && widthOf(`${text.slice(0, length)}…`) > most) length -= 1;
  return length > 0 ? `${text.slice(0, length).trimEnd()}…` : "";
}
