import { dictionary } from "../../../../lib/i18n";

export const t = dictionary({
  moments: { en: "Marked moments", ru: "Отмеченные моменты" },
  at: { en: "{at} of {count}", ru: "{at} из {count}" },
  fromStart: { en: "{seconds} s from the start", ru: "{seconds} с от начала" },
  none: { en: "no such moments", ru: "таких моментов нет" },
  next: { en: "Next marked moment", ru: "Следующий отмеченный момент" },
  previous: { en: "Previous marked moment", ru: "Предыдущий отмеченный момент" },
  clear: { en: "Remove the marks", ru: "Снять отметки" },
  table: { en: "Back to the table", ru: "Назад к таблице" },
  scatter: { en: "Back to the cloud", ru: "Назад к облаку" },
});
