// A rule of actions as a person edits it: texts, until it is saved.
import { fieldText, language, localized, parsedNumber } from "../../lib/i18n";
import type { ActionRule, Text } from "../../lib/api/types";

export interface Draft {
  name: string;
  when: string;
  hold: string;
  until: string;
  again: string;
  once: boolean;
  mark: string;
  record: "" | "start" | "stop";
  sound: boolean;
  speak: string;
  mqtt: boolean;
  webhook: string;
}

const seconds = (value: number) => (value === 0 ? "" : fieldText(value));

export function draftOf(rule: ActionRule | null): Draft {
  return {
    name: rule?.name ?? "",
    when: rule?.when ?? "",
    hold: seconds(rule?.hold ?? 0),
    until: rule?.until ?? "",
    again: seconds(rule?.again ?? 0),
    once: rule?.once ?? false,
    mark: rule?.mark ? localized(textOf(rule.mark)) : "",
    record: rule?.record ?? "",
    sound: rule?.sound ?? false,
    speak: rule?.speak ? localized(textOf(rule.speak)) : "",
    mqtt: rule?.mqtt ?? false,
    webhook: rule?.webhook ?? "",
  };
}

const textOf = ({ en, ru }: { en?: string; ru?: string }): Text => ({ en: en ?? "", ru: ru ?? "" });

/** One text for both languages, unless there were two; null: none. */
function texts(typed: string, before: { en?: string; ru?: string } | null | undefined): Text | null {
  const words = typed.trim();
  if (words === "") return null;
  const two = before && before.en !== before.ru;
  return two ? { ...textOf(before), [language.code]: words } : { en: words, ru: words };
}

/** The first field that holds no number of seconds; undefined: both do, or are empty. */
export const wrongSeconds = ({ hold, again }: Draft): string | undefined =>
  [hold, again].find((each) => {
    const number = parsedNumber(each);
    return number === undefined || (number !== null && number < 0);
  });

/** The rule to save; the seconds are numbers or empty. `before`: the rule that was edited. */
export function ruleOf(draft: Draft, before: ActionRule | null): ActionRule {
  return {
    name: draft.name.trim(),
    when: draft.when.trim(),
    hold: parsedNumber(draft.hold) ?? 0,
    until: draft.until.trim(),
    again: parsedNumber(draft.again) ?? 0,
    once: draft.once,
    mark: texts(draft.mark, before?.mark),
    record: draft.record || null,
    sound: draft.sound,
    speak: texts(draft.speak, before?.speak),
    mqtt: draft.mqtt,
    webhook: draft.webhook.trim(),
  };
}

/** Where a rule is wrong, of the program's words that begin with the key in the file: “`action.hot.speak`: …”; without one, the condition. */
export function placed({ en, ru }: Text): { field: string; problem: Text } {
  const key = /^`action\.[^`]*?(?:\.(\w+))?`:? /;
  return { field: key.exec(en)?.[1] ?? "when", problem: { en: en.replace(key, ""), ru: ru.replace(key, "") } };
}

/** The keys of what a rule does. */
export const doneBy = (rule: ActionRule) =>
  [
    rule.mark ? ("mark" as const) : null,
    rule.record ? (`record_${rule.record}` as const) : null,
    rule.sound ? ("sound" as const) : null,
    rule.speak ? ("speak" as const) : null,
    rule.mqtt ? ("mqtt" as const) : null,
    rule.webhook ? ("webhook" as const) : null,
  ].filter((key) => key !== null);
