import { describe, expect, it } from "vitest";
import type { Fault } from "../../lib/api/types";
import { faultsText } from "./message";

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
const reading = (name: string) => (name === "JAIR" ? "JAIR 15.1 kg/h" : null);

describe("faultsText", () => {
  it("lists every fault, known or unknown", () => {
    const text = faultsText({ time: 0, count: 2, faults: [fault(13, "Air mass low"), fault(99, "")] }, ["Mikas 7.1"], reading);
    expect(text).toBe(
      "Stored faults\nMikas 7.1\n\n13: Air mass low (Meaning confirmed by two sources)\n   Check first: the plug\n   Now: JAIR 15.1 kg/h\n" +
        "99: The meaning of this number is unknown (Meaning unknown)\n   Now: JAIR 15.1 kg/h\n",
    );
  });
  it("states that there are none", () => {
    expect(faultsText({ time: 0, count: 0, faults: [] }, [], reading)).toBe("Stored faults\n\nNo faults are stored.\n");
  });
});
