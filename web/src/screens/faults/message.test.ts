import { describe, expect, it } from "vitest";
import type { Fault } from "../../lib/api/types";
import { faultsText, type Labels } from "./message";

const fault = (code: number, text: string): Fault => ({
  code,
  text: { en: text, ru: "" },
  confidence: text ? "confirmed" : "unknown",
  certain: Boolean(text),
  frame: null,
  informational: false,
  check: text ? { en: "the plug", ru: "" } : null,
  related: ["JAIR"],
  sensor: [],
  first_seen: 0,
});
const labels: Labels = {
  title: "Faults",
  none: "none",
  unknown: "not known",
  check: "check",
  now: "now",
  sure: (confidence) => confidence,
  text: (it) => it.text.en,
  check_text: (it) => it.check?.en ?? "",
  reading: (name) => (name === "JAIR" ? "JAIR 15.1 kg/h" : null),
};

describe("faultsText", () => {
  it("lists every fault, known or unknown", () => {
    const text = faultsText({ time: 0, count: 2, faults: [fault(13, "Air mass low"), fault(99, "")] }, ["Mikas 7.1"], labels);
    expect(text).toBe(
      "Faults\nMikas 7.1\n\n13: Air mass low (confirmed)\n   check: the plug\n   now: JAIR 15.1 kg/h\n" +
        "99: not known (unknown)\n   now: JAIR 15.1 kg/h\n",
    );
  });
  it("states that there are none", () => {
    expect(faultsText({ time: 0, count: 0, faults: [] }, [], labels)).toBe("Faults\n\nnone\n");
  });
});
