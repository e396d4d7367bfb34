// The chart as an SVG drawing on white: title, legend with the values at the cursor, panes with axes and lines, flags, time axis. Real
// vectors and texts, so that it prints sharply and can be edited. What is drawn is collected by `picture.ts`.
import { roundValues } from "../../../../lib/pairs/bins";
import { wrapText } from "../data/flags";

export interface PictureLine {
  colour: string;
  dashed: boolean;
  /** Pieces between interruptions: points of time and value. */
  pieces: [number, number][][];
  stepped: boolean;
  /** The reference's range, behind the line. */
  band: readonly [number, number] | null;
  low: number;
  high: number;
}

export interface PictureAxis {
  colour: string;
  low: number;
  high: number;
  floor: boolean;
}

export interface PicturePane {
  legend: { colour: string; name: string; value: string; more: string }[];
  axes: PictureAxis[];
  lines: PictureLine[];
}

export interface Picture {
  title: string;
  subtitle: string;
  from: number;
  to: number;
  panes: PicturePane[];
  gaps: { from: number; to: number; reason: string }[];
  flags: { time: number; text: string; colour: string }[];
  cursors: { time: number; text: string; dashed: boolean }[];
  /** Places and labels of the time axis. */
  times: { time: number; text: string }[];
  number: (value: number) => string;
}

const WIDTH = 1280;
const LEGEND = 210;
const LEFT = LEGEND + 58;
const RIGHT = 58;
const HEAD = 64;
const FLAGS = 40;
const PANE = 150;
const SPACE = 14;
const FOOT = 34;
const INNER = WIDTH - LEFT - RIGHT;
const FONT = "Segoe UI, Roboto, Noto Sans, Liberation Sans, DejaVu Sans, sans-serif";
const TEXT = "#0b0f12";
const MUTED = "#434d55";
const GRID = "#e3e7ea";
/** The width of a letter, as a share of the size: texts are not measured, so that the drawing is the same everywhere. */
const LETTER = 0.56;

const ENTITIES: Record<string, string> = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&apos;" };

/** Escape a text for XML; characters that no XML may have are left out. */
export function escaped(text: string): string {
  return (
    text
      // eslint-disable-next-line no-control-regex -- those are what is left out
      .replace(/[\u0000-\u0008\u000B\u000C\u000E-\u001F\uFFFE\uFFFF]|[\uD800-\uDFFF](?![\uDC00-\uDFFF])/gu, "")
      .replace(/[&<>"']/g, (sign) => ENTITIES[sign]!)
  );
}

type Attributes = Record<string, string | number | undefined>;

function element(name: string, attributes: Attributes, inside = ""): string {
  const given = Object.entries(attributes).filter(([, value]) => value !== undefined);
  const written = given
    .map(([key, value]) => ` ${key}="${typeof value === "number" ? Number(value.toFixed(1)) : escaped(value!)}"`)
    .join("");
  return inside ? `<${name}${written}>${inside}</${name}>` : `<${name}${written}/>`;
}

const words = (x: number, y: number, size: number, text: string, more: Attributes = {}): string =>
  element("text", { x, y, "font-size": size, fill: TEXT, ...more }, escaped(text));

/** The round values of an axis: two to seven. */
export const ticks = (low: number, high: number, floor = false): number[] =>
  roundValues(low, high, 6).filter((value) => !floor || value >= 0);

/** The size of the drawing in pixels. */
export const sizeOf = (picture: Picture) => ({ width: WIDTH, height: HEAD + FLAGS + picture.panes.length * (PANE + SPACE) + FOOT });

export function chartSvg(picture: Picture): string {
  const { width, height } = sizeOf(picture);
  const x = (time: number) => LEFT + ((time - picture.from) / (picture.to - picture.from)) * INNER;
  const bottom = height - FOOT - SPACE;
  const parts = [
    element("rect", { width, height, fill: "#ffffff" }),
    words(16, 28, 20, short(picture.title, 20), { "font-weight": "700" }),
    words(16, 50, 14, picture.subtitle, { fill: MUTED }),
    ...picture.panes.map((pane, index) => drawPane(picture, pane, index, x)),
    ...flags(picture, x),
    ...picture.times.map(({ time, text }) => words(x(time), bottom + 18, 12, text, { fill: MUTED, "text-anchor": "middle" })),
    ...picture.cursors.flatMap(({ time, text, dashed }) => {
      const right = x(time) > LEFT + INNER * 0.7;
      return [
        element("line", {
          x1: x(time),
          x2: x(time),
          y1: HEAD + 24,
          y2: bottom,
          stroke: TEXT,
          "stroke-width": "1.2",
          "stroke-dasharray": dashed ? "6 4" : undefined,
        }),
        words(x(time) + (right ? -4 : 4), HEAD + 35, 12, text, { "text-anchor": right ? "end" : "start" }),
      ];
    }),
  ];
  const hatch = element(
    "pattern",
    { id: "gap", width: 8, height: 8, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
    element("line", { x1: 0, x2: 0, y1: 0, y2: 8, stroke: "#6b7680", "stroke-width": "1" }),
  );
  const clips = picture.panes.map((_, index) =>
    element("clipPath", { id: `pane${index}` }, element("rect", { x: LEFT, y: topOf(index), width: INNER, height: PANE })),
  );
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" font-family="${FONT}"><title>${escaped(picture.title)}</title><defs>${hatch}${clips.join("")}</defs>${parts.join("\n")}</svg>`;
}

/** A line across the drawing, cut to its width. */
const short = (text: string, size: number): string => wrapText(text, (part) => part.length * size * LETTER <= WIDTH - 32, 1)[0] ?? "";

const topOf = (index: number) => HEAD + FLAGS + index * (PANE + SPACE);

function drawPane(picture: Picture, pane: PicturePane, index: number, x: (time: number) => number): string {
  const top = topOf(index);
  const y = (value: number, low: number, high: number) => top + PANE - ((value - low) / (high - low)) * PANE;
  const parts = picture.times.map(({ time }) => element("line", { x1: x(time), x2: x(time), y1: top, y2: top + PANE, stroke: GRID }));
  pane.axes.forEach(({ low, high, floor, colour }, side) => {
    for (const value of ticks(low, high, floor)) {
      const at = y(value, low, high);
      if (side === 0) parts.push(element("line", { x1: LEFT, x2: LEFT + INNER, y1: at, y2: at, stroke: GRID }));
      const place: Attributes = side === 0 ? { "text-anchor": "end" } : {};
      parts.push(words(side === 0 ? LEFT - 6 : LEFT + INNER + 6, at + 4, 12, picture.number(value), { fill: colour, ...place }));
    }
  });
  for (const { from, to, reason } of picture.gaps) {
    const [begin, end] = [Math.max(LEFT, x(from)), Math.min(LEFT + INNER, x(to))];
    if (end <= begin) continue;
    parts.push(element("rect", { x: begin, y: top, width: Math.max(1, end - begin), height: PANE, fill: "url(#gap)", opacity: "0.6" }));
    if (index !== picture.panes.length - 1 || end - begin < 60) continue;
    const lines = wrapText(reason, (text) => text.length * 11 * LETTER <= end - begin - 8, 3);
    lines.forEach((text, row) => {
      const at = top + PANE - 6 - 14 * (lines.length - 1 - row);
      parts.push(
        element("rect", { x: begin + 2, y: at - 11, width: text.length * 11 * LETTER + 4, height: 14, fill: "#ffffff" }),
        words(begin + 4, at, 11, text),
      );
    });
  }
  const stripes = pane.lines.map(({ band, low, high, colour }) => {
    if (!band) return "";
    const [bottom, top] = [y(band[0], low, high), y(band[1], low, high)];
    return element("rect", { x: LEFT, y: top, width: INNER, height: Math.max(1, bottom - top), fill: colour, "fill-opacity": "0.15" });
  });
  const drawn = pane.lines.flatMap((line) =>
    line.pieces.map((piece) =>
      element("path", {
        d: pathOf(piece, line, x, (value) => y(value, line.low, line.high)),
        fill: "none",
        stroke: line.colour,
        "stroke-width": line.dashed ? "1.2" : "1.6",
        "stroke-linejoin": "round",
        "stroke-dasharray": line.dashed ? "5 4" : undefined,
      }),
    ),
  );
  parts.push(element("g", { "clip-path": `url(#pane${index})` }, [...stripes, ...drawn].join("")));
  parts.push(element("rect", { x: LEFT, y: top, width: INNER, height: PANE, fill: "none", stroke: "#6b7680" }), legend(pane, top));
  return parts.join("\n");
}

function pathOf(piece: [number, number][], { stepped }: PictureLine, x: (time: number) => number, y: (value: number) => number): string {
  const points = piece.map(([time, value]) => [x(time).toFixed(1), y(value).toFixed(1)] as const);
  const [first, ...rest] = points;
  if (rest.length === 0) return `M${first!.join(" ")}h0.5`;
  const lines = rest.map(([across, down]) => (stepped ? `H${across}V${down}` : `L${across} ${down}`));
  return `M${first!.join(" ")}${lines.join("")}`;
}

/** The names of up to three traces have two lines each, of more one line. */
function legend({ legend: rows }: PicturePane, top: number): string {
  const each = Math.min(48, PANE / Math.max(1, rows.length));
  return rows
    .map(({ colour, name, value, more }, index) => {
      const y = top + 12 + index * each;
      const [first, second] = each >= 32 ? [name, value] : [`${name}: ${value}`, ""];
      const size = Math.min(12, each * 0.8);
      const [short] = wrapText(first, (text) => text.length * size * LETTER <= LEGEND - 56, 1);
      const shown =
        each >= 32
          ? short!
          : wrapText(name, (text) => (text.length + value.length + 2) * size * LETTER <= LEGEND - 56, 1)[0]! + `: ${value}`;
      return [
        element("rect", { x: 16, y: y - 5, width: 18, height: 4, fill: colour }),
        words(40, y, size, shown, second ? { fill: MUTED } : {}),
        second ? words(40, y + 18, 15, second, { "font-weight": "700" }) : "",
        second && more ? words(40, y + 31, 11, more, { fill: MUTED }) : "",
      ].join("");
    })
    .join("\n");
}

/** Flags with their texts, each as far as the next one. */
function flags(picture: Picture, x: (time: number) => number): string[] {
  const placed = picture.flags.map((flag) => ({ ...flag, at: x(flag.time) })).sort((one, other) => one.at - other.at);
  return placed.map(({ at, text, colour }, index) => {
    const room = Math.min(260, (placed[index + 1]?.at ?? WIDTH) - at - 6);
    const [shown = ""] = room < 14 ? [""] : wrapText(text, (words) => words.length * 12 * LETTER <= room, 1);
    return (
      element("line", { x1: at, x2: at, y1: HEAD + 4, y2: HEAD + FLAGS, stroke: colour, "stroke-width": "1.5" }) +
      words(at + 4, HEAD + 16, 12, shown, { fill: colour })
    );
  });
}
