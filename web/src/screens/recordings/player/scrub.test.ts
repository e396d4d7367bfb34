import { describe, expect, it } from "vitest";
import { language } from "../../../lib/i18n";
import { faster, keyStep, precise, share, slower } from "./scrub";

describe("the player bar", () => {
  it("steps through the speeds and stops at the ends", () => {
    expect([faster(1), faster(16), slower(1), slower(0.25)]).toEqual([2, 16, 0.5, 0.25]);
  });
  it("maps a time to a share", () => {
    expect([share(5, 0, 10), share(-1, 0, 10), share(11, 0, 10), share(1, 1, 1)]).toEqual([0.5, 0, 1, 0]);
  });
  it("maps keys to steps", () => {
    expect(keyStep("ArrowLeft", false)).toBe(-1);
    expect(keyStep("ArrowRight", true)).toBe(10);
    expect(keyStep("Home", false)).toBe(-Infinity);
    expect(keyStep("a", false)).toBeNull();
  });
  it("never shows sixty seconds", () => {
    expect([precise(0), precise(59.97), precise(65.25)]).toEqual(["00:00.0", "01:00.0", "01:05.3"]);
    expect([precise(0.021, 2), precise(59.999, 2), precise(65.25, 2)]).toEqual(["00:00.02", "01:00.00", "01:05.25"]);
  });
  it("has the decimal sign of the language", () => {
    language.code = "ru";
    expect(precise(65.25)).toBe("01:05,3");
    language.code = "en";
  });
});
