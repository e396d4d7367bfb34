import { describe, expect, it } from "vitest";
import { matches, type Binding } from "./shortcuts";

const bound = (more: Partial<Binding>): Binding => ({ code: "KeyM", show: "M", text: () => "", run: () => undefined, ...more });

describe("a key", () => {
  it("matches its place in every layout", () => {
    expect(matches(bound({}), { code: "KeyM", key: "ь", shiftKey: false })).toBe(true);
    expect(matches(bound({}), { code: "KeyM", key: "Ь", shiftKey: true })).toBe(false);
    expect(matches(bound({}), { code: "KeyB", key: "m", shiftKey: false })).toBe(false);
  });

  it("with a character of its own also matches that character", () => {
    const help = bound({ code: "Slash", shift: true, key: "?" });
    expect(matches(help, { code: "Slash", key: "?", shiftKey: true })).toBe(true);
    expect(matches(help, { code: "Digit7", key: "?", shiftKey: true })).toBe(true);
    expect(matches(help, { code: "Digit7", key: "7", shiftKey: false })).toBe(false);
  });
});
