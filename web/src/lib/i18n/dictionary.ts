// The texts of a screen in both languages side by side; the types require both.
//
//   const t = dictionary({ title: { en: "Faults", ru: "Ошибки" },
//                          count: { en: { one: "{n} fault", other: "{n} faults" },
//                                   ru: { one: "{n} ошибка", few: "{n} ошибки", many: "{n} ошибок" } } });
//   t("title"); t("count", { n: 3 })
import { number } from "./formats";
import { language, type Code } from "./language.svelte";

type Forms = Partial<Record<Intl.LDMLPluralRule, string>>;
type Message = string | Forms;
type Params = Record<string, string | number>;

const rules: Record<Code, Intl.PluralRules> = { en: new Intl.PluralRules("en"), ru: new Intl.PluralRules("ru") };

export function dictionary<Key extends string>(messages: Record<Key, Record<Code, Message>>): (key: Key, params?: Params) => string {
  return (key, params) => {
    const message = messages[key][language.code];
    const text = typeof message === "string" ? message : form(message, Number(params?.n ?? 0));
    return params ? fill(text, params) : text;
  };
}

function form(forms: Forms, n: number): string {
  const rule = rules[language.code].select(n);
  return forms[rule] ?? forms.other ?? forms.many ?? forms.few ?? forms.one ?? "";
}

function fill(text: string, params: Params): string {
  return text.replace(/\{(\w+)\}/g, (whole, name: string) => {
    const value = params[name];
    if (value === undefined) return whole;
    return typeof value === "number" ? number(value) : value;
  });
}
