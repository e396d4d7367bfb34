// The passport as names and values, for the screen, the copied text and the saved file.
import { byteText } from "../memory/cells/hex";
import { DASH, number, localized } from "../../lib/i18n";
import type { Passport, UnitCommand } from "../../lib/api/types";
import { methods, t } from "./messages";

export type Line = readonly [name: string, value: string];

type Method = Parameters<typeof methods>[0];
const METHODS: readonly Method[] = ["stream", "list", "batch", "single"];

/** The method in words; an unknown one (stroke0 … stroke4) by its name. */
export function methodText(name: string | null): string {
  if (!name) return DASH;
  const known = METHODS.find((it) => it === name);
  return known ? methods(known) : name;
}

/** The filled fields. Null (the ECU does not support the command) and "" (not filled in) have different texts. */
export function piecesText(pieces: readonly (string | null)[]): string {
  if (pieces.every((piece) => piece === null)) return t("not_supported");
  const filled = pieces.filter((piece) => piece?.trim());
  return filled.length > 0 ? filled.join(" · ") : t("not_filled");
}

export function unitLines(passport: Passport): Line[] {
  return [
    [t("model"), localized(passport.model)],
    [t("version_code"), passport.version_code],
    [t("program"), piecesText(passport.program_passport)],
    [t("data"), piecesText(passport.data_passport)],
    [t("parameters"), passport.parameter_count === null ? t("not_supported") : number(passport.parameter_count)],
  ];
}

export function lineLines(passport: Passport): Line[] {
  const { latency_ms: latency } = passport;
  return [
    [t("adapter"), passport.port.startsWith("sim:") ? t("virtual") : passport.adapter || DASH],
    [t("port"), passport.port || DASH],
    [t("echo"), passport.echo ? t("echo_yes") : t("echo_no")],
    [t("baud"), t("baud_value", { n: passport.baud })],
    [t("latency"), latency === null ? t("not_measured") : t("latency_value", { n: number(latency, 0) })],
  ];
}

export function measuredLines(passport: Passport): Line[] {
  const { max_list: list, max_block: blocks, refused } = passport.limits;
  const { pause } = passport;
  const rates = Object.entries(passport.rates);
  return [
    [t("method"), methodText(passport.method)],
    ...rates.map(([name, rate]): Line => {
      return [methodText(name), rate > 0 ? t("rate_value", { n: number(rate, 1) }) : t("rate_none")];
    }),
    [t("max_list"), t("max_list_value", { n: list })],
    [t("pause"), pause > 0 ? t("latency_value", { n: number(pause * 1000, 0) }) : t("pause_none")],
    ...Object.entries(blocks).map(([space, count]): Line => {
      return [t("max_block", { space: space.toUpperCase() }), t("bytes", { n: count })];
    }),
    [t("refused"), refused.length > 0 ? refused.map(byteText).join(" ") : t("none")],
  ];
}

export function commandLines(passport: Passport): Line[] {
  return (passport.supported ?? []).map((command) => {
    return [`${byteText(command.code)} ${localized(command.title)}`, answerText(command)];
  });
}

export function answerText({ supported, reason }: Pick<UnitCommand, "supported" | "reason">): string {
  if (supported === null && reason) return t("not_tried_because", { reason: localized(reason) });
  return supported === null ? t("not_tried") : supported ? t("knows") : t("knows_not");
}

/** The passport as text: one line for each name and value, in aligned columns. */
export function sheetText(title: string, lines: readonly Line[]): string {
  const width = Math.max(0, ...lines.map(([name]) => name.length));
  const body = lines.map(([name, value]) => `${name.padEnd(width)}  ${value}`.trimEnd());
  return [title, "", ...body, ""].join("\n");
}

/** A file name such as `mikas-7.1-A1234.json`, without characters that file systems reject. */
export function fileName(parts: readonly (string | null | undefined)[], suffix: string): string {
  const clean = parts.map((part) => (part ?? "").replace(/[^\p{L}\p{N}.-]+/gu, "-").replace(/^[-.]+|[-.]+$/g, "")).filter(Boolean);
  return `${clean.join("-") || "mikas"}.${suffix}`;
}
