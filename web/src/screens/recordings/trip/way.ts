// The way's lines on a drawing with a grid of its own: no map, nothing from elsewhere. North is above; one scale for both directions.
import type { TripWay } from "../../../lib/api/types";

const HEIGHTS = { least: 150, most: 480 };
const EDGE = 14;
/** Below the way, for the scale. */
const FOOT = 26;
/** m that the drawing shows at least. */
const LEAST = 50;
/** From left to right at least; at most thirteen. */
const CELLS = 5;

export interface Drawing {
  height: number;
  paths: { level: number | null; d: string }[];
  begin: [number, number];
  end: [number, number];
  /** Places of the grid's lines. */
  columns: number[];
  rows: number[];
  /** Of a cell: metres, and on the drawing. */
  step: number;
  side: number;
}

/** The drawing of a way of one line or more, so many pixels wide. */
export function drawingOf({ lines }: Pick<TripWay, "lines">, width: number): Drawing {
  const [west, east] = endsOf(lines.map((line) => line.east));
  const [south, north] = endsOf(lines.map((line) => line.north));
  const inside = width - 2 * EDGE;
  const high = Math.min(HEIGHTS.most, Math.max(HEIGHTS.least, (inside * (north - south)) / (east - west)));
  const metres = Math.max((east - west) / inside, (north - south) / high);
  const height = high + EDGE + FOOT;
  const left = (west + east) / 2 - (metres * width) / 2;
  const top = (south + north) / 2 + metres * (EDGE + high / 2);
  const place = (e: number, n: number): [number, number] => [rounded((e - left) / metres), rounded((top - n) / metres)];
  const paths = lines.map(({ level, east: easts, north: norths }) => ({
    level,
    d: `M${easts.map((e, at) => place(e, norths[at]!).join(" ")).join("L")}`,
  }));
  const step = roundStep((metres * width) / CELLS);
  const side = step / metres;
  const first = lines[0]!;
  const last = lines.at(-1)!;
  return {
    height: rounded(height),
    paths,
    begin: place(first.east[0]!, first.north[0]!),
    end: place(last.east.at(-1)!, last.north.at(-1)!),
    columns: places(side, width),
    rows: places(side, height),
    step,
    side: rounded(side),
  };
}

/** The greatest of 1, 2, 5, 10 … that is not above `most`. */
export function roundStep(most: number): number {
  const power = 10 ** Math.floor(Math.log10(most));
  return power * ([5, 2].find((each) => each * power <= most) ?? 1);
}

function endsOf(values: number[][]): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (const each of values) for (const value of each) [low, high] = [Math.min(low, value), Math.max(high, value)];
  const lacking = Math.max(0, LEAST - (high - low)) / 2;
  return [low - lacking, high + lacking];
}

function places(side: number, end: number): number[] {
  const found: number[] = [];
  for (let at = side; at < end; at += side) found.push(rounded(at));
  return found;
}

const rounded = (value: number) => Math.round(value * 10) / 10;
