import { dictionary } from "../../lib/i18n";

export const t = dictionary({
  compare: { en: "Compare with…", ru: "Сравнить с…" },
  compare_of: { en: "Compare {name} with…", ru: "Сравнить {name} с…" },
  compare_to: { en: "Compare {first} with {name}", ru: "Сравнить {first} с {name}" },
  verb: { en: "Compare", ru: "Сравнить" },
  title: { en: "Compare {name} with", ru: "Сравнить {name} с записью" },
  lead: {
    en: "Both are drawn in the chart over the same clock: seconds from the beginning of each.",
    ru: "Обе рисуются на одном графике по общим часам: секунды от начала каждой.",
  },
  search: { en: "Search: car, note, fault", ru: "Поиск: машина, заметка, код" },
  nothing: {
    en: "There is no other recording yet. Record another drive, or put the other car’s file into the folder of the recordings.",
    ru: "Другой записи пока нет. Запишите ещё одну поездку или положите файл другой машины в папку записей.",
  },
  none_found: { en: "Nothing matches “{text}”.", ru: "По запросу «{text}» ничего нет." },
  unreadable: { en: "no values in it", ru: "нет значений" },
  unknown_car: { en: "unknown unit", ru: "блок неизвестен" },

  bar: { en: "Comparison", ru: "Сравнение" },
  solid: { en: "solid:", ru: "сплошная:" },
  dashed: { en: "dashed:", ru: "пунктир:" },
  offset: { en: "Second one moved by, seconds", ru: "Вторая сдвинута, секунд" },
  moved: { en: "moved by {seconds} s", ru: "сдвиг {seconds} с" },
  earlier: { en: "Second one {seconds} s to the left", ru: "Вторую на {seconds} с влево" },
  later: { en: "Second one {seconds} s to the right", ru: "Вторую на {seconds} с вправо" },
  zero: { en: "Both from their beginning", ru: "Обе от своего начала" },
  align: { en: "Align…", ru: "Совместить…" },
  align_long: { en: "Align by a moment: first on the dashed line, then on the solid one", ru: "Совместить по моменту: сначала на пунктире, потом на сплошной" },
  align_stop: { en: "Don’t align", ru: "Не совмещать" },
  end: { en: "End the comparison", ru: "Закончить сравнение" },
  in_chart: { en: "The comparison is in the chart", ru: "Сравнение на графике" },
  loaded: { en: "read {n} %", ru: "прочитано {n} %" },
});
