// The report of a problem with a cable, as text to paste: what those who read it can't know. No name of a file, a car or a person is in it.
import type { DoctorStep, Port } from "../../../lib/api/types";
import { localized } from "../../../lib/i18n";
import { t } from "../messages";
import { markSteps, OTHER_UNITS } from "./steps";

export interface Reported {
  version: string;
  browser: string;
  /** Those that are adapters, or the one in use. */
  ports: readonly Port[];
  /** The port in use or last tried. */
  port: string | null;
  /** Headline, advice and error, as they stand on the screen. */
  says: readonly string[];
  unit: string;
  /** Of the last connection check. */
  steps: readonly DoctorStep[];
}

const FORMS = "https://github.com/mikas-diagnostics/mikas/issues/new?template=";
/** Where a report is sent to; by hand: the page sends nothing. */
export const formFor = (agent: string): string => `${FORMS}${agent.includes("Android") ? "phone.yml" : "car.yml"}`;

export function problemReport({ version, browser, ports, port, says, unit, steps }: Reported): string {
  const cables = ports.map(({ chip, description, url }) => `${chip || description} (${url})`);
  return [
    `mikas ${version}`,
    `${t("report_browser")}: ${browser}`,
    `${t("report_cables")}: ${cables.join(", ") || t("report_none")}`,
    `${t("report_port")}: ${port ?? t("report_none")}`,
    `${t("report_says")}: ${[...new Set(says.filter(Boolean))].join(" / ") || t("report_none")}`,
    `${t("n_ecu")}: ${unit || t("report_none")}`,
    ...(steps.length > 0 ? [`${t("doctor")}:`, ...stepLines(steps)] : [`${t("doctor")}: ${t("report_none")}`]),
  ].join("\n");
}

function stepLines(steps: readonly DoctorStep[]): string[] {
  const others = steps.some(({ name }) => OTHER_UNITS.some((it) => it === name));
  return markSteps(steps, false, others).map(({ name, mark, step }) => {
    const said = step ? [localized(step.detail), localized(step.to_try)].filter(Boolean).join(" ") : "";
    return `- ${t(`n_${name}`)}: ${t(`step_${mark}`)}${said && `. ${said}`}`;
  });
}
