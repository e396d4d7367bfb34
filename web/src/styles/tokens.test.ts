import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";

const css = readFileSync(new URL("./tokens.css", import.meta.url), "utf8");

type Tokens = Record<string, string>;

/** The colours of a theme, by name without dashes. */
function theme(name: "night" | "day"): Tokens {
  const block = css.split(`:root[data-theme="${name}"] {`)[1]!.split("}")[0]!;
  return Object.fromEntries([...block.matchAll(/--([\w-]+): (#[0-9a-f]{6});/g)].map(([, key, value]) => [key!, value!]));
}

const parts = (colour: string): number[] => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));

function luminance(channels: number[]): number {
  const [red, green, blue] = channels.map((channel) => {
    const share = channel / 255;
    return share <= 0.03928 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * red! + 0.7152 * green! + 0.0722 * blue!;
}

/** As WCAG counts; `opacity` of what lies on the ground. */
function contrast(over: string, ground: string, opacity = 1): number {
  const under = parts(ground);
  const mixed = parts(over).map((channel, at) => channel * opacity + under[at]! * (1 - opacity));
  const [dark, light] = [luminance(mixed), luminance(under)].sort((a, b) => a - b);
  return (light! + 0.05) / (dark! + 0.05);
}

describe.each(["night", "day"] as const)("by %s", (name) => {
  const colours = theme(name);
  const of = (over: string, ground: string, opacity?: number) => contrast(colours[over]!, colours[ground]!, opacity);

  it.each([
    ["text", "ground"],
    ["text", "raised"],
    ["text", "sunken"],
    ["text", "hover"],
    ["text", "warning-ground"],
    ["text", "danger-ground"],
    ["warning", "raised"],
    ["danger", "raised"],
    ["danger", "danger-ground"],
    ["on-signal", "warning"],
    ["on-signal", "danger"],
  ])("a value is read in the sun: %s on %s ≥ 7", (over, ground) => {
    expect(of(over, ground)).toBeGreaterThanOrEqual(7);
  });

  it.each(["ground", "raised", "sunken", "hover", "ok-ground", "warning-ground", "danger-ground"])("small words on %s ≥ 4.5", (ground) => {
    for (const over of ["muted", "accent", "ok", "warning", "danger"]) expect(of(over, ground)).toBeGreaterThanOrEqual(4.5);
  });

  it("buttons ≥ 4.5", () => {
    expect(of("on-accent", "accent")).toBeGreaterThanOrEqual(4.5);
    expect(of("on-danger-button", "danger-button")).toBeGreaterThanOrEqual(4.5);
  });

  it("stale values ≥ 4.5", () => {
    const stale = Number(/--stale: ([\d.]+);/.exec(css)![1]);
    for (const ground of ["ground", "raised", "sunken", "hover"]) expect(of("text", ground, stale)).toBeGreaterThanOrEqual(4.5);
  });

  it("lines, bands and edges ≥ 3", () => {
    const drawn = Object.keys(colours).filter((key) => /^trace-|-band$|^reference$|^strong-line$/.test(key));
    expect(drawn).toHaveLength(12);
    for (const over of drawn) {
      expect(of(over, "ground"), over).toBeGreaterThanOrEqual(3);
      expect(of(over, "raised"), over).toBeGreaterThanOrEqual(3);
    }
    expect(of("danger-button", "raised")).toBeGreaterThanOrEqual(3);
  });
});
