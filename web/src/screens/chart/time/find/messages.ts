import { dictionary } from "../../../../lib/i18n";

export const t = dictionary({
  find: { en: "Find…", ru: "Найти…" },
  findLong: { en: "Find moments by a condition", ru: "Найти моменты по условию" },
  title: { en: "Find moments", ru: "Найти моменты" },
  live: { en: "In the values of this connection, up to two hours back.", ru: "В значениях этого подключения, не больше двух часов назад." },
  recorded: { en: "In the recording {name}.", ru: "В записи {name}." },
  condition: { en: "Condition", ru: "Условие" },
  hint: { en: "Names of values, numbers, comparisons, and, or, not. A moment ends where the condition is false or has no value for two seconds.", ru: "Имена величин, числа, сравнения, и, или, не (and, or, not). Момент кончается там, где условие неверно или две секунды не имеет значения." },
  examples: { en: "For example", ru: "Например" },
  kept: { en: "Saved conditions", ru: "Сохранённые условия" },
  keep: { en: "Save this condition", ru: "Сохранить условие" },
  drop: { en: "Delete {expression}", ru: "Удалить {expression}" },
  go: { en: "Find", ru: "Найти" },
  none: { en: "At no moment: {expression}", ru: "Ни в один момент: {expression}" },
  peakHigh: { en: "{expression} ({what} up to {peak})", ru: "{expression} ({what} до {peak})" },
  peakLow: { en: "{expression} ({what} down to {peak})", ru: "{expression} ({what} до {peak})" },
  first: { en: "{title}; the first {n} of {count}", ru: "{title}; первые {n} из {count}" },
});
