import { describe, expect, it } from "vitest";
import { matches, type Binding } from "./shortcuts.svelte";

const bound = (more: Partial<Binding>): Binding => ({ code: "KeyM", show: "M", text: () => "", run: () => undefined, ...more });

describe("a key", () => {
  it("is known by its place, whatever letter the layout has there", () => {
    expect(matches(bound({}), { code: "KeyM", key: "ь", shiftKey: false })).toBe(true);
    expect(matches(bound({}), { code: "KeyM", key: "Ь", shiftKey: true })).toBe(false);
    expect(matches(bound({}), { code: "KeyB", key: "m", shiftKey: false })).toBe(false);
  });

  it("with a sign of its own is known by the sign as well", () => {
    const help = bound({ code: "Slash", shift: true, key: "?" });
    expect(matches(help, { code: "Slash", key: "?", shiftKey: true })).toBe(true);
    expect(matches(help, { code: "Digit7", key: "?", shiftKey: true })).toBe(true);
    expect(matches(help, { code: "Digit7", key: "7", shiftKey: false })).toBe(false);
  });
});
