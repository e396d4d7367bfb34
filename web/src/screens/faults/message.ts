// The faults as plain text for a message: texts, confidence, what to check, and the ECU. The labels are passed in, in the reader's
// language.

import type { Fault, Faults } from "../../lib/api/types";

export interface Labels {
  title: string;
  none: string;
  unknown: string;
  check: string;
  now: string;
  sure: (confidence: string) => string;
  text: (of: Fault) => string;
  check_text: (of: Fault) => string;
  reading: (name: string) => string | null;
}

export function faultsText(faults: Faults, about: readonly string[], labels: Labels): string {
  const lines = [labels.title, ...about.filter(Boolean), ""];
  if (faults.faults.length === 0) lines.push(labels.none);
  for (const fault of faults.faults) {
    lines.push(`${fault.code}: ${labels.text(fault) || labels.unknown} (${labels.sure(fault.confidence)})`);
    const check = labels.check_text(fault);
    if (check) lines.push(`   ${labels.check}: ${check}`);
    const readings = fault.related.map(labels.reading).filter((it) => it !== null);
    if (readings.length > 0) lines.push(`   ${labels.now}: ${readings.join(", ")}`);
  }
  return `${lines.join("\n")}\n`;
}
