// What the sheet of a passport says, of units that answer everything and of those that do not.
import { describe, expect, it } from "vitest";
import type { Passport } from "../../lib/api/types";
import { answerText, commandLines, fileName, lineLines, measuredLines, methodText, piecesText, sheetText, unitLines } from "./lines";

const PASSPORT: Passport = {
  model: { en: "Mikas 7.1", ru: "Микас 7.1" },
  version_code: "0A",
  program_passport: ["PROGRAM", "", null],
  data_passport: [null, null],
  parameter_count: 42,
  port: "/dev/ttyUSB0",
  adapter: "FT232R",
  echo: true,
  pause: 0.1,
  baud: 9600,
  latency_ms: 16,
  method: "stroke2",
  rates: { stream: 104.25, single: 0 },
  limits: { max_list: 8, max_block: { ram: 32 }, refused: [0x0a, 0xff] },
  supported: [
    { code: 0x02, name: "faults", source_name: "", title: { en: "Faults", ru: "Неисправности" }, supported: true, reason: null },
    { code: 0x1f, name: "other", source_name: "", title: { en: "Other", ru: "Другое" }, supported: false, reason: null },
  ],
};

describe("the lines of a passport", () => {
  it("tell a passport that the unit does not send from one that is not filled in", () => {
    expect(piecesText([null, null])).toBe("not supported by this ECU");
    expect(piecesText(["", "  ", null])).toBe("not filled in");
    expect(piecesText(["A", null, "C"])).toBe("A · C");
  });
  it("name the unit", () => {
    expect(unitLines(PASSPORT)).toEqual([
      ["Model", "Mikas 7.1"],
      ["Answer to request 01", "0A"],
      ["Program passport", "PROGRAM"],
      ["Data passport", "not supported by this ECU"],
      ["Parameters", "42"],
    ]);
    expect(unitLines({ ...PASSPORT, parameter_count: null }).at(-1)).toEqual(["Parameters", "not supported by this ECU"]);
  });
  it("name the adapter and its line", () => {
    expect(lineLines(PASSPORT).map(([, value]) => value)).toEqual([
      "FT232R",
      "/dev/ttyUSB0",
      "yes, every byte is checked",
      "9600 bit/s",
      "16 ms",
    ]);
    const virtual = lineLines({ ...PASSPORT, port: "sim:", echo: false, latency_ms: null });
    expect(virtual.map(([, value]) => value)).toEqual([
      "virtual ECU",
      "sim:",
      "the adapter suppresses it",
      "9600 bit/s",
      "not reported by the system",
    ]);
  });
  it("give what was measured, and bytes in hex", () => {
    expect(measuredLines(PASSPORT)).toEqual([
      ["Sampling method in use", "stroke2"],
      ["stream (71): the unit sends by itself", "104.3 readings/s"],
      [methodText("single"), "does not work"],
      ["Longest list in one request", "8 parameters"],
      ["Pause from a response to the next request", "100 ms"],
      ["Largest block of RAM", "32 bytes"],
      ["Parameters it does not support", "0A FF"],
    ]);
    const none = { ...PASSPORT, limits: { ...PASSPORT.limits, refused: [] } };
    expect(measuredLines(none).at(-1)?.[1]).toBe("none");
    expect(measuredLines({ ...PASSPORT, pause: 0 })).toContainEqual(["Pause from a response to the next request", "not needed"]);
  });
  it("say of a command whether the unit knows it, or why that is unknown", () => {
    expect(commandLines(PASSPORT)).toEqual([
      ["02 Faults", "supported"],
      ["1F Other", "not supported"],
    ]);
    expect(answerText({ supported: null, reason: null })).toBe("unknown");
    const reason = { en: "the engine stands", ru: "двигатель стоит" };
    expect(answerText({ supported: null, reason })).toBe("unknown: the engine stands");
    expect(commandLines({ ...PASSPORT, supported: null })).toEqual([]);
  });
});

describe("the passport sheet", () => {
  it("has aligned columns", () => {
    expect(
      sheetText("T", [
        ["a", "1"],
        ["long", "2"],
      ]),
    ).toBe("T\n\na     1\nlong  2\n");
  });
  it("has a file name without special characters", () => {
    expect(fileName(["Mikas 7.1", null, "  ", "А/Б:1"], "json")).toBe("Mikas-7.1-А-Б-1.json");
    expect(fileName([null], "txt")).toBe("mikas.txt");
  });
});
