import { describe, expect, it } from "vitest";
import { chartSvg, escaped, sizeOf, ticks, type Picture } from "./chartSvg";
import { piecesOf } from "./pieces";

const picture: Picture = {
  title: 'Mikas 7.1 · drive <1> & "2"',
  subtitle: "23 Nov 2026",
  from: 100,
  to: 160,
  panes: [
    {
      legend: [{ colour: "#0072b2", name: "Crankshaft speed", value: "840 rpm", more: "" }],
      axes: [{ colour: "#0072b2", low: -15, high: 500, floor: true }],
      lines: [
        {
          colour: "#0072b2",
          dashed: false,
          stepped: false,
          band: [100, 200],
          low: -15,
          high: 500,
          pieces: [
            [
              [100, 0],
              [130, 500],
            ],
            [[140, 250]],
          ],
        },
      ],
    },
  ],
  gaps: [{ from: 130, to: 140, reason: "no answer" }],
  flags: [{ time: 120, text: "⚑ rattle", colour: "#0b0f12" }],
  cursors: [{ time: 110, text: "12:00:10", dashed: false }],
  times: [{ time: 120, text: "12:00:20" }],
  number: String,
};

describe("the drawing", () => {
  const svg = chartSvg(picture);

  it("is well-formed, on white, with texts, vectors and nothing outside", () => {
    const { width, height } = sizeOf(picture);
    expect(svg.startsWith(`<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}"`)).toBe(true);
    expect(svg).toContain('fill="#ffffff"');
    expect(svg).not.toMatch(/<image|<script|href=|<foreignObject/);
    for (const text of ["drive &lt;1&gt; &amp; &quot;2&quot;", "Crankshaft speed", "840 rpm", "⚑ rattle", "12:00:10", "12:00:20"])
      expect(svg).toContain(text);
    const open: string[] = [];
    for (const [, end, name, alone] of svg.matchAll(/<(\/?)([A-Za-z]+)[^>]*?(\/?)>/g)) {
      if (end) expect(open.pop()).toBe(name);
      else if (!alone) open.push(name!);
    }
    expect(open).toEqual([]);
    expect(svg).not.toMatch(/NaN|Infinity|undefined/);
  });

  it("has a path for each piece of a line, at its place", () => {
    const paths = [...svg.matchAll(/<path d="([^"]*)"/g)].map(([, d]) => d);
    expect(paths).toEqual(["M268.0 249.6L745.0 104.0", "M904.0 176.8h0.5"]);
    // From 100 to 200 on an axis from -15 to 500, 150 high.
    expect(svg).toContain('<rect x="268" y="191.4" width="954" height="29.1" fill="#0072b2" fill-opacity="0.15"/>');
  });
});

it("texts are escaped, and signs that XML does not have are left out", () => {
  expect(escaped(`a<b>&"'\u0000\u001b\ud800c`)).toBe("a&lt;b&gt;&amp;&quot;&apos;c");
});

it("an axis has a few round values, none below 0 where there are none", () => {
  expect(ticks(-15, 500, true)).toEqual([0, 100, 200, 300, 400, 500]);
  expect(ticks(13.2, 15.2)).toEqual([13.5, 14, 14.5, 15]);
  expect(ticks(5, 5)).toEqual([]);
});

it("a line is interrupted between two points only", () => {
  const cells = [1, 2, null, undefined, 3, 4];
  expect(piecesOf([0, 1, 2, 3, 4, 5], cells, [])).toEqual([
    [
      [0, 1],
      [1, 2],
      [4, 3],
      [5, 4],
    ],
  ]);
  expect(piecesOf([0, 1, 2, 3, 4, 5], cells, [[1, 4]])).toEqual([
    [
      [0, 1],
      [1, 2],
    ],
    [
      [4, 3],
      [5, 4],
    ],
  ]);
  expect(
    piecesOf([0, 1, 2, 3, 4, 5], cells, [
      [4.2, 4.8],
      [1, 4],
    ]),
  ).toHaveLength(3);
});

it("a line that stands still goes up to its interruption and on behind it", () => {
  const cells = [7, undefined, undefined, undefined, 7, 9];
  const times = [0, 10, 20, 30, 40, 50];
  expect(piecesOf(times, cells, [[12, 18]])).toEqual([
    [
      [0, 7],
      [12, 7],
    ],
    [
      [18, 7],
      [40, 7],
      [50, 9],
    ],
  ]);
  expect(
    piecesOf(times, cells, [
      [32, 38],
      [12, 18],
      [10, 15],
    ]),
  ).toEqual([
    [
      [0, 7],
      [10, 7],
    ],
    [
      [18, 7],
      [32, 7],
    ],
    [
      [38, 7],
      [40, 7],
      [50, 9],
    ],
  ]);
  expect(piecesOf(times, cells, [[0, 40]])).toEqual([
    [[0, 7]],
    [
      [40, 7],
      [50, 9],
    ],
  ]);
});
