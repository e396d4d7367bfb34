import { afterEach, describe, expect, it } from "vitest";
import { dictionary } from "./dictionary";
import { clock, hex, number, percent, size, spaced } from "./formats";
import { language } from "./language.svelte";

afterEach(() => {
  language.code = "en";
});

describe("numbers", () => {
  it("have a comma in Russian, a minus sign, and no grouping", () => {
    language.code = "ru";
    expect(number(14.25, 1)).toBe("14,3");
    expect(number(-0.469, 3)).toBe("−0,469");
    expect(number(12345, 0)).toBe("12345");
    language.code = "en";
    expect(number(14.25, 2)).toBe("14.25");
  });

  it("are a dash when there is none", () => {
    expect([number(null), number(undefined), number(NaN, 1), number(Infinity)]).toEqual(["–", "–", "–", "–"]);
  });

  it("have no minus before a zero", () => {
    expect(number(-0.04, 1)).toBe("0.0");
    expect(number(-0, 0)).toBe("0");
  });
});

describe("other formats", () => {
  it("follow the language", () => {
    language.code = "ru";
    expect(percent(0.973)).toBe("97 %");
    expect(size(999)).toBe("999 Б");
    expect(size(10_720)).toBe("10,7 КБ");
    expect(size(2_340_000)).toBe("2,3 МБ");
    expect([clock(61), clock(3723.9), clock(-1), clock(null)]).toEqual(["01:01", "1:02:03", "00:00", "–"]);
    expect([hex(0xa7), hex(5, 2), spaced("01F9A0")]).toEqual(["0x00A7", "0x05", "01 F9 A0"]);
  });
});

describe("a dictionary", () => {
  const t = dictionary({
    found: { en: { one: "{n} fault", other: "{n} faults" }, ru: { one: "{n} ошибка", few: "{n} ошибки", many: "{n} ошибок" } },
    rate: { en: "{rate} sets/s", ru: "{rate} наб/с" },
  });

  it("selects plural forms of both languages", () => {
    expect([1, 2, 0].map((n) => t("found", { n }))).toEqual(["1 fault", "2 faults", "0 faults"]);
    language.code = "ru";
    expect([1, 2, 5, 11, 21, 104].map((n) => t("found", { n }))).toEqual([
      "1 ошибка",
      "2 ошибки",
      "5 ошибок",
      "11 ошибок",
      "21 ошибка",
      "104 ошибки",
    ]);
  });

  it("formats numbers and leaves missing parameters in place", () => {
    language.code = "ru";
    expect(t("rate", { rate: 34.8 })).toBe("34,8 наб/с");
    expect(t("rate", {})).toBe("{rate} наб/с");
  });
});
