// Sizes of text, spaces and radii are tokens, and styles change at few widths of the window. What has to differ says why in its line,
// after "off the scale:"; a hair's line of 1 px, parts of a text's own size (em) and of its box are free.
import { readdirSync, readFileSync } from "node:fs";
import { expect, it } from "vitest";

/** All widths and heights at which a style may change, in px; a media query can't hold a token. */
const BREAKPOINTS = { width: [700, 1100, 1400], height: [500] };
const root = new URL("..", import.meta.url);
const files = readdirSync(root, { recursive: true, encoding: "utf8" }).filter((name) => /\.(svelte|css)$/.test(name));
const sources = files.map((name) => ({ name, text: readFileSync(new URL(name, root), "utf8") }));
const styles = sources.map(({ name, text }) => ({ name, css: name.endsWith(".css") ? text : (text.split("<style>")[1] ?? "") }));
const SCALED =
  /^\s*(?:(?:[a-z][a-z-]*-)?radius|font(?:-size)?|(?:padding|margin)[a-z-]*|(?:row-|column-)?gap): .*?(?<![\w.-])-?(?!1px)[\d.]+(?:px|rem)\b/;

it("every size of text, space and radius is a token", () => {
  const literal = styles.flatMap(({ name, css }) =>
    css.split("\n").flatMap((line) => (SCALED.test(line) && !line.includes("off the scale: ") ? [`${name}: ${line.trim()}`] : [])),
  );
  // The size of the page's text, of which all others are parts.
  expect(literal).toEqual(["styles/base.css: font: 16px/1.45 var(--font);"]);
});

it("every token that is used exists", () => {
  const known = new Set(sources.flatMap(({ text }) => [...text.matchAll(/--([\w-]+)(?:: |=)/g)].map(([, token]) => token)));
  const missing = sources.flatMap(({ name, text }) => [...text.matchAll(/var\(--([\w-]+)[),]/g)].map(([, token]) => ({ name, token })));
  expect(missing.filter(({ token }) => !known.has(token))).toEqual([]);
});

it("styles change at few sizes of the window", () => {
  const used = styles.flatMap(({ name, css }) =>
    [...css.matchAll(/@media [^{]*/g)].flatMap(([query]) =>
      [...query.matchAll(/(min|max)-(width|height): (\d+)px/g)].map(([, side, axis, size]) => ({ name, side, axis, size: Number(size) })),
    ),
  );
  const allowed = ({ side, axis, size }: (typeof used)[number]) =>
    BREAKPOINTS[axis as keyof typeof BREAKPOINTS].includes(side === "min" ? size - 1 : size);
  expect(used.filter((each) => !allowed(each))).toEqual([]);
});
