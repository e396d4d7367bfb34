// The faults as plain text for a message: texts, confidence, what to check, and the ECU.
import type { Faults } from "../../lib/api/types";
import { localized } from "../../lib/i18n";
import { t } from "./messages";

/** `reading`: the present value of a channel; null: there is none. */
export function faultsText({ faults }: Faults, about: readonly string[], reading: (name: string) => string | null): string {
  const lines = [t("message_title"), ...about.filter(Boolean), ""];
  if (faults.length === 0) lines.push(t("message_none"));
  for (const { code, text, confidence, check, related } of faults) {
    lines.push(`${code}: ${localized(text) || t("unknown")} (${t(`sure_${confidence}`)})`);
    if (localized(check)) lines.push(`   ${t("check")}: ${localized(check)}`);
    const readings = related.map(reading).filter((it) => it !== null);
    if (readings.length > 0) lines.push(`   ${t("related")}: ${readings.join(", ")}`);
  }
  return `${lines.join("\n")}\n`;
}
