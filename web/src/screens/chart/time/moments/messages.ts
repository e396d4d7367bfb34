import { dictionary } from "../../../../lib/i18n";

export const t = dictionary({
  moments: { en: "Found moments", ru: "Найденные моменты" },
  at: { en: "{at} of {count}", ru: "{at} из {count}" },
  fromStart: { en: "{seconds} s from the start", ru: "{seconds} с от начала" },
  none: { en: "no such moments", ru: "таких моментов нет" },
  next: { en: "Next found moment", ru: "Следующий найденный момент" },
  previous: { en: "Previous found moment", ru: "Предыдущий найденный момент" },
  clear: { en: "Hide these moments", ru: "Убрать эти моменты с графика" },
  markAll: { en: "Set markers ({n})", ru: "Поставить отметки ({n})" },
  markThis: { en: "Set a marker here", ru: "Поставить отметку здесь" },
  placed: { en: { one: "{n} marker set", other: "{n} markers set" }, ru: { one: "Поставлена {n} отметка", few: "Поставлено {n} отметки", many: "Поставлено {n} отметок" } },
  table: { en: "Back to the table", ru: "Назад к таблице" },
  scatter: { en: "Back to the cloud", ru: "Назад к облаку" },
});
